#include "tools/lab/examples/results.h"

namespace padr::lab::examples {
namespace {

constexpr int kDominoes = 20;

/// A story in all its takes, with what truly happens in them.
struct Production {
  Story story;
  std::vector<TrueStory> truths;
};

Production produce(const std::string& name, int dominoes, const Plan& plan) {
  Production p{story_by_name(name, dominoes), {}};
  for (int take = 0; take < plan.takes; ++take) p.truths.push_back(true_story(p.story, take));
  return p;
}

std::vector<Cost> all_takes(const Production& p, const Technique& technique, const Plan& plan) {
  std::vector<Cost> costs;
  costs.reserve(p.truths.size());
  for (int take = 0; take < plan.takes; ++take)
    costs.push_back(measure(p.story, take, p.truths[static_cast<std::size_t>(take)], technique, plan.netem));
  return costs;
}

/// Every predictor without authority against none, story by story. Each story begins with no predictor.
std::vector<Verdict> verdicts_of(const std::vector<Result>& results, std::size_t variants) {
  std::vector<Verdict> verdicts;
  for (std::size_t first = 0; first < results.size(); first += variants)
    for (std::size_t i = first; i < first + variants; ++i) {
      const Result& one = results[i];
      if (one.variant.predictor.empty() || one.variant.technique.authority) continue;
      verdicts.push_back(judge(one.story, one.variant, results[first].takes, one.takes));
    }
  return verdicts;
}

}  // namespace

Results run_plan(const Plan& plan) {
  const std::vector<Variant> all = variants();
  const std::size_t stories = plan.stories.size();
  const auto productions = parallel_results<Production>(
      stories, [&](std::size_t i) { return produce(plan.stories[i], kDominoes, plan); }, plan.parallel);
  Results r;
  r.results = parallel_results<Result>(
      stories * all.size(),
      [&](std::size_t i) {
        const Production& p = productions[i / all.size()];
        Result one{p.story.name, p.story.scene.bodies.size(), all[i % all.size()], {}, {}};
        one.takes = all_takes(p, one.variant.technique, plan);
        one.mean = mean_of(one.takes);
        return one;
      },
      plan.parallel);
  r.verdicts = verdicts_of(r.results, all.size());
  bool dominoes = false;
  for (const std::string& s : plan.stories) dominoes = dominoes || s == "dominoes";
  if (!dominoes) return r;
  r.rows = parallel_results<RowOfDominoes>(
      kDominoes,
      [&](std::size_t i) {
        const int count = static_cast<int>(i) + 1;
        const Production p = produce("dominoes", count, plan);
        return RowOfDominoes{count, mean_of(all_takes(p, without_authority().technique, plan)),
                             mean_of(all_takes(p, with_authority().technique, plan))};
      },
      plan.parallel);
  return r;
}

Line cost_per_domino(const std::vector<RowOfDominoes>& rows) {
  double n = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0;
  for (const RowOfDominoes& r : rows) {
    const double cost = r.without_authority.final_m;
    n += 1;
    x += r.count;
    y += cost;
    xx += static_cast<double>(r.count) * r.count;
    xy += r.count * cost;
    yy += cost * cost;
  }
  const double sxx = n * xx - x * x;
  const double syy = n * yy - y * y;
  const double sxy = n * xy - x * y;
  if (sxx <= 0 || syy <= 0) return {};
  return {sxy / sxx, sxy * sxy / (sxx * syy)};
}

}  // namespace padr::lab::examples
