#include "tools/lab/compare/fields.h"

#include <array>
#include <type_traits>

namespace padr::lab::compare {
namespace {

template <auto First, auto... Rest>
auto& at(auto& of) {
  if constexpr (sizeof...(Rest) == 0)
    return of.*First;
  else
    return at<Rest...>(of.*First);
}

template <auto... Path>
constexpr Field field(const char* name, bool (*has)(const Score&) = has_any) {
  return {name, [](const Score& s) { return static_cast<double>(at<Path...>(s)); },
          [](Score& s, double v) {
            auto& place = at<Path...>(s);
            place = static_cast<std::remove_reference_t<decltype(place)>>(v);
          },
          has};
}

using trace::Fidelity;
using trace::Inconsistency;

constexpr std::array<Field, 29> kFields{{
    field<&Score::off, &Inconsistency::mean_m>("mean_m"),
    field<&Score::off, &Inconsistency::avatar_mean_m>("avatar_mean_m"),
    field<&Score::off, &Inconsistency::body_mean_m>("body_mean_m"),
    field<&Score::off, &Inconsistency::p95_m>("p95_m"),
    field<&Score::off, &Inconsistency::p99_m>("p99_m"),
    field<&Score::off, &Inconsistency::peak_m>("peak_m"),
    field<&Score::off, &Inconsistency::final_m>("final_m"),
    field<&Score::off, &Inconsistency::shown_mean_m>("shown_mean_m"),
    field<&Score::delay_s>("delay_s"),
    field<&Score::delayed_mean_m>("delayed_mean_m"),
    field<&Score::hands_mean_m>("hands_mean_m"),
    field<&Score::hand_delay_s>("hand_delay_s"),
    field<&Score::hand_delay_peak_s>("hand_delay_peak_s"),
    field<&Score::frozen_share>("frozen_share"),
    field<&Score::freezes>("freezes_per_s"),
    field<&Score::jumps>("jumps_per_s"),
    field<&Score::jump_m>("jump_mean_m", has_jumps),
    field<&Score::kbps>("kbit_per_s"),
    field<&Score::datagrams>("datagrams_per_s"),
    field<&Score::updates>("updates_per_s"),
    field<&Score::largest>("largest_datagram_bytes"),
    field<&Score::fidelity, &Fidelity::mean_m>("fidelity_mean_m"),
    field<&Score::fidelity, &Fidelity::own_mean_m>("fidelity_own_mean_m"),
    field<&Score::fidelity, &Fidelity::others_mean_m>("fidelity_others_mean_m"),
    field<&Score::fidelity, &Fidelity::nobody_mean_m>("fidelity_nobody_mean_m"),
    field<&Score::fidelity, &Fidelity::p95_m>("fidelity_p95_m"),
    field<&Score::fidelity, &Fidelity::peak_m>("fidelity_peak_m"),
    field<&Score::measured_share>("measured_share"),
    field<&Score::mismatches>("confirmed_mismatches"),
}};

}  // namespace

std::span<const Field> fields() {
  return kFields;
}

}  // namespace padr::lab::compare
