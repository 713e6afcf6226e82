#include "common/model/portable_math.h"

#include <box2d/box2d.h>
#include <dlfcn.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <limits>
#include <memory>
#include <string>

#include "common/model/hash.h"
#include "common/model/rng.h"
#include "common/world/fingerprint.h"
#include "common/world/world.h"

namespace padr {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Distance in units in the last place of the better value.
double ulps(float got, double exact) {
  const auto rounded = static_cast<float>(exact);
  const float next = std::nextafter(std::fabs(rounded), std::numeric_limits<float>::infinity());
  return std::fabs(static_cast<double>(got) - exact) / static_cast<double>(next - std::fabs(rounded));
}

// Worst seen is a hair above the half unit that any rounding costs.
constexpr double kAllowed = 0.5001;

TEST(PortableMath, SineAndCosineAreRoundedAsWellAsCanBe) {
  Rng rng(1);
  for (const double range : {0.001, 1.0, 4.0, 1000.0, 500'000.0}) {
    for (int i = 0; i < 100'000; ++i) {
      const auto x = static_cast<double>(static_cast<float>(rng.uniform(-range, range)));
      const SinCos both = sin_cos(x);
      ASSERT_LE(ulps(static_cast<float>(both.sin), std::sin(x)), kAllowed) << x;
      ASSERT_LE(ulps(static_cast<float>(both.cos), std::cos(x)), kAllowed) << x;
    }
  }
}

TEST(PortableMath, ArcTangentIsRoundedAsWellAsCanBe) {
  Rng rng(2);
  for (const double range : {1e-3, 1.0, 1e6}) {
    for (int i = 0; i < 100'000; ++i) {
      const auto y = static_cast<double>(static_cast<float>(rng.uniform(-range, range)));
      const auto x = static_cast<double>(static_cast<float>(rng.uniform(-1, 1)));
      ASSERT_LE(ulps(static_cast<float>(arc_tangent(y, x)), std::atan2(y, x)), kAllowed) << y << ' ' << x;
    }
  }
}

TEST(PortableMath, BinaryLogarithmIsGoodToItsLastBits) {
  Rng rng(5);
  for (const double range : {1.5, 100.0, 1e30}) {
    for (int i = 0; i < 100'000; ++i) {
      const double x = rng.uniform(1 / range, range);
      const double exact = std::log2(x);
      ASSERT_LE(std::fabs(binary_logarithm(x) - exact), 1e-15 * std::max(1.0, std::fabs(exact))) << x;
    }
  }
  for (const int e : {-1022, -1, 0, 1, 1023}) EXPECT_EQ(binary_logarithm(std::ldexp(1, e)), e);
}

TEST(PortableMath, SpecialCasesAreTheStandards) {
  for (const double y : {0.0, -0.0, 1.0, -1.0, kInfinity, -kInfinity})
    for (const double x : {0.0, -0.0, 1.0, -1.0, kInfinity, -kInfinity}) {
      const double got = arc_tangent(y, x);
      EXPECT_DOUBLE_EQ(got, std::atan2(y, x)) << y << ' ' << x;
      EXPECT_EQ(std::signbit(got), std::signbit(y)) << y << ' ' << x;
    }
  EXPECT_TRUE(std::isnan(arc_tangent(std::nan(""), 1)));
  EXPECT_TRUE(std::isnan(sin_cos(kInfinity).sin));
  EXPECT_EQ(sin_cos(0).sin, 0);
  EXPECT_EQ(sin_cos(0).cos, 1);
  EXPECT_LE(std::fabs(sin_cos(1e15).sin), 1.01);
}

// What every processor and compiler must get, whatever the C library does on it. The test runs with the library's AVX2
// and FMA variants switched off as well (.ci/run determinism).
TEST(PortableMath, EveryBitIsTheSameEverywhere) {
  Rng rng(3);
  Hasher h;
  Hasher logarithms;
  for (int i = 0; i < 1'000'000; ++i) {
    const auto x = static_cast<float>(rng.uniform(-100, 100));
    const auto y = static_cast<float>(rng.uniform(-100, 100));
    const SinCos both = sin_cos(static_cast<double>(x));
    h.add(static_cast<float>(both.sin), static_cast<float>(both.cos));
    h.add(static_cast<float>(arc_tangent(static_cast<double>(y), static_cast<double>(x))));
    logarithms.add(static_cast<float>(binary_logarithm(std::fabs(static_cast<double>(x)))));
  }
  EXPECT_EQ(h.value(), 5082531295692383533ULL);
  EXPECT_EQ(logarithms.value(), 10412920384772398080ULL);
}

// As a package Box2D is a library of its own: what it calls is what the dynamic linker finds first.
TEST(PortableMath, Box2dCallsIt) {
  b2World world({0, 0});
  b2BodyDef def;
  b2Body* body = world.CreateBody(&def);
#ifndef PADR_BOX2D_STATIC
  for (const char* name : {"sinf", "cosf", "sincosf", "atan2f"}) {
    Dl_info info{};
    void* found = dlsym(RTLD_DEFAULT, name);
    ASSERT_NE(found, nullptr) << name;
    ASSERT_NE(dladdr(found, &info), 0);
    EXPECT_EQ(std::string(info.dli_fname).find("libm."), std::string::npos) << name << " is " << info.dli_fname;
  }
#endif
  Rng rng(4);
  for (int i = 0; i < 100'000; ++i) {
    const auto angle = static_cast<float>(rng.uniform(-10, 10));
    body->SetTransform({0, 0}, angle);
    const SinCos both = sin_cos(static_cast<double>(angle));
    ASSERT_EQ(body->GetTransform().q.s, static_cast<float>(both.sin)) << angle;
    ASSERT_EQ(body->GetTransform().q.c, static_cast<float>(both.cos)) << angle;
  }
}

/// What a process of its own, with other C library variants allowed, says its fingerprint is.
std::string fingerprint_under(const std::string& tunables) {
  const std::string command = "GLIBC_TUNABLES=" + tunables + " '" +
                              std::filesystem::read_symlink("/proc/self/exe").string() +
                              "' --gtest_filter=PortableMath.SaysItsFingerprint";
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), pclose);
  std::string said;
  std::array<char, 256> line{};
  while (pipe && std::fgets(line.data(), line.size(), pipe.get()) != nullptr)
    if (std::string(line.data()).starts_with("fingerprint ")) said = line.data();
  return said;
}

TEST(PortableMath, SaysItsFingerprint) {
  EXPECT_NE(world::physics_fingerprint(), 0U);
  std::cout << "fingerprint " << std::hex << world::physics_fingerprint() << '\n';
}

// The canned simulation whose hash peers compare at joining.
TEST(PortableMath, TheFingerprintDoesNotDependOnTheCLibrarysVariants) {
  const std::string here = fingerprint_under("");
  EXPECT_NE(here, "");
  EXPECT_EQ(fingerprint_under("glibc.cpu.hwcaps=-AVX2,-FMA"), here);
  EXPECT_EQ(fingerprint_under("glibc.cpu.hwcaps=-AVX2_Usable,-FMA_Usable,-FMA4_Usable"), here);
}

}  // namespace
}  // namespace padr
