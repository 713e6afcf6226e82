#include "tools/monitor/guard.h"

#include <gtest/gtest.h>

namespace padr::monitor {
namespace {

const std::vector<std::string> kNames{"monitor", "lab.example"};

TEST(Guard, AddressesAndItsOwnNamesAreServed) {
  for (const char* host : {"127.0.0.1", "127.0.0.1:8080", "192.168.1.20:1", "[::1]", "[::1]:8080", "[fe80::1]:65535",
                           "localhost", "LocalHost:8080", "monitor:8080", "MONITOR", "lab.example:80"})
    EXPECT_TRUE(host_allowed(host, kNames)) << host;
}

// A page of evil.example that makes its own name point at us asks for that name.
TEST(Guard, OtherNamesAreNot) {
  for (const char* host : {"",
                           ":",
                           "evil.example",
                           "evil.example:8080",
                           "localhost.evil.example",
                           "127.0.0.1.evil.example",
                           "127.0.0.1:",
                           "127.0.0.1:port",
                           "127.0.0.1:123456",
                           "1.2.3",
                           "1.2.3.4.5",
                           "1.2.3.",
                           "a.2.3.4",
                           "[::1",
                           "::1",
                           "[evil]",
                           "[]",
                           "monitorx",
                           "monitor evil",
                           "127.0.0.1, evil"})
    EXPECT_FALSE(host_allowed(host, kNames)) << host;
}

TEST(Guard, OnlyItsOwnPagesMayConnect) {
  EXPECT_TRUE(same_origin("http://127.0.0.1:8080", "127.0.0.1:8080"));
  EXPECT_TRUE(same_origin("https://Lab.example", "lab.example"));
  for (const char* origin : {"", "null", "http://", "http://127.0.0.1:8081", "http://127.0.0.1", "http://evil.example",
                             "http://127.0.0.1:8080.evil.example", "http://evil@127.0.0.1:8080",
                             "file://127.0.0.1:8080", "127.0.0.1:8080", "http://127.0.0.1:8080/"})
    EXPECT_FALSE(same_origin(origin, "127.0.0.1:8080")) << origin;
}

TEST(Guard, TargetsArePlain) {
  const auto t = split_target("/api/path?peer=3&x=");
  ASSERT_TRUE(t);
  EXPECT_EQ(t->path, "/api/path");
  EXPECT_EQ(query_field(t->query, "peer"), "3");
  EXPECT_EQ(query_field(t->query, "x"), "");
  EXPECT_FALSE(query_field(t->query, "pee"));
  EXPECT_FALSE(query_field("", "peer"));
  for (const char* target : {"", "*", "index.html", "http://x/", "/%2e%2e", "/a b", "/\x01", "/a\"", "/\xC3\xA9",
                             "/a&b", "/=", "/?a b", "/?a=\x7F", "/?\xC3\xA9", "/?a\n"})
    EXPECT_FALSE(split_target(target)) << target;
  // Once, whoever followed a link with such a query saw "no such target".
  for (const char* target : {"/?foo=b%C3%A4r", "/?utm_source=a+b", "/?a?b", "/?"}) {
    const auto odd = split_target(target);
    ASSERT_TRUE(odd) << target;
    EXPECT_EQ(odd->path, "/") << target;
    EXPECT_FALSE(query_field(odd->query, "sample")) << target;
  }
}

TEST(Guard, SecretsAreTheSameOrNot) {
  EXPECT_TRUE(same_secret("12345678", "12345678"));
  EXPECT_FALSE(same_secret("12345678", "12345679"));
  EXPECT_FALSE(same_secret("12345678", "1234567"));
  EXPECT_FALSE(same_secret("", "1"));
}

}  // namespace
}  // namespace padr::monitor
