#include "tools/lab/figures/html.h"

#include <filesystem>

#include "shell/files.h"
#include "shell/revision.h"
#include "shell/text.h"
#include "tools/lab/figures/words.h"

namespace padr::lab::figures {
namespace {

constexpr const char* kStyle = R"(
  body { font: 16px/1.5 sans-serif; color: #222; max-width: 60rem; margin: 2rem auto; padding: 0 1rem; }
  h1 { font-size: 1.6rem; } h2 { font-size: 1.25rem; margin-top: 2.5rem; border-top: 1px solid #ccc; padding-top: 1rem; }
  svg { max-width: 100%; height: auto; }
  .wide { overflow-x: auto; }
  table { border-collapse: collapse; font-size: 0.9rem; margin: 1rem 0; }
  th, td { padding: 0.25rem 0.6rem; text-align: right; border-bottom: 1px solid #ddd; vertical-align: top; }
  th:first-child, td:first-child { text-align: left; }
  .claim { display: grid; grid-template-columns: 1fr 1fr; gap: 0 1.5rem; background: #f5f5f5; padding: 0.8rem 1rem; margin: 1rem 0; }
  .claim h3 { grid-column: 1 / 3; margin: 0 0 0.3rem; font-size: 1rem; }
  .claim p { margin: 0.2rem 0; }
  .small { color: #555; font-size: 0.85rem; }
  figure { margin: 1rem 0; } details { margin: 0.5rem 0; } summary { cursor: pointer; }
)";

/// All drawings name their parts alike, and in one page a name may be there once.
std::string with_own_ids(std::string svg, const std::string& name) {
  for (const std::string_view begin : {" id='", " id=\"", "href='#", "url(#"})
    for (std::size_t at = 0; (at = svg.find(begin, at)) != std::string::npos;) {
      at += begin.size();
      svg.insert(at, name + "-");
    }
  return svg;
}

class Page {
 public:
  Page(std::string dir, const Plan& plan, const Results& results, const std::vector<Claim>& claims, bool pictures)
      : dir_(std::move(dir)), plan_(plan), results_(results), claims_(claims), pictures_(pictures) {}

  std::string text();

 private:
  void add(const std::string& s) { out_ += s + "\n"; }
  void head();
  void claims_of(const std::string& figure);
  /// One picture in the page, without the lines that only a file of its own has. `title` is for who does not see it.
  void picture(const std::string& name, const std::string& title);
  /// The first case's at once, the others' on request.
  void pictures_of(const std::string& figure);
  void settings_table();
  void causes_table();
  void predictors_table();
  void cases_table();

  std::string dir_;
  const Plan& plan_;
  const Results& results_;
  const std::vector<Claim>& claims_;
  bool pictures_;
  std::string out_;
};

void Page::head() {
  add("<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">");
  add("<meta name=\"viewport\" content=\"width=device-width\">");
  add(std::string("<title>The paper's experiments</title>\n<style>") + kStyle + "</style>\n</head>\n<body>\n<main>");
  add("<h1>The paper's experiments, measured</h1>");
  add("<p>Two peers; the avatar of one is driven, the other rests and watches. Combined inconsistency is the sum over "
      "all entities of the distance between where the watching peer has them and where their authority has them at the "
      "same tick; for a body that nobody owns see docs/report.md. Below 5 mm it is noise. Scenario <b>" +
      shell::html_escaped(plan_.scenario) + "</b>, " + std::to_string(plan_.cases.size()) + " cases of " +
      fixed(plan_.seconds(), 0) +
      " s each, network: " + (plan_.netem_text.empty() ? "unimpaired" : shell::html_escaped(plan_.netem_text)) +
      ". The paper gives no world sizes, masses or constants: ours are our own choice, so shapes can be compared with "
      "its "
      "figures, heights cannot.</p>");
  add("<p class=\"small\">" + shell::html_escaped(plan_.command) + "<br>padr-lab " + std::string(shell::version()) +
      ", revision " + std::string(shell::revision()) + "</p>");
}

void Page::claims_of(const std::string& figure) {
  for (const Claim& c : claims_) {
    if (c.figure != figure) continue;
    const std::string verdict = c.on_average ? "holds on average" : "does not hold on average";
    add("<div class=\"claim\"><h3>" + verdict + ", and in " + shell::html_escaped(share_text(c)) +
        "</h3><div><p><b>The paper.</b> " + shell::html_escaped(c.says) + "</p></div><div><p><b>Measured.</b> " +
        shell::html_escaped(c.measured) + "</p><p class=\"small\">Asked: " + shell::html_escaped(c.test) +
        ".</p></div></div>");
  }
}

void Page::picture(const std::string& name, const std::string& title) {
  if (!pictures_) {
    add("<p class=\"small\">(" + name + " was not drawn)</p>");
    return;
  }
  const std::string svg = shell::read_file("--out", (std::filesystem::path(dir_) / (name + ".svg")).string());
  constexpr std::string_view kTag = "<svg";
  const std::size_t begin = svg.find(kTag);
  const std::string rest = begin == std::string::npos ? "></svg>" : svg.substr(begin + kTag.size());
  add("<figure><svg role=\"img\" aria-label=\"" + shell::html_escaped(title) + "\"" + with_own_ids(rest, name) +
      "</figure>");
}

void Page::pictures_of(const std::string& figure) {
  const auto add_one = [&](const Case& c) {
    picture("figure" + figure + "-" + c.id, "Figure " + figure + ": " + c.title);
  };
  add_one(plan_.cases[0]);
  for (std::size_t c = 1; c < plan_.cases.size(); ++c) {
    add("<details><summary>" + shell::html_escaped(plan_.cases[c].title) + "</summary>");
    add_one(plan_.cases[c]);
    add("</details>");
  }
}

void Page::settings_table() {
  add("<div class=\"wide\" tabindex=\"0\"><table><tr><th>means of all cases</th><th>input</th><th>combined "
      "(m)</th><th>avatars</th><th>bodies</th><th>last third</th>"
      "<th>99 % below</th><th>peak</th><th>bodies' peak</th><th>free ticks within threshold</th><th>updates a "
      "minute</th><th>kbit/s</th></tr>");
  for (const Setting& s : plan_.settings) {
    std::string title = shell::html_escaped(s.title);
    for (const std::string& kind : kinds_of(plan_)) {
      const auto cell = [&](double (*number)(const Measures&), int digits) {
        return "<td>" + fixed(mean_of(over_cases(plan_, results_, s.id, number, kind)), digits) + "</td>";
      };
      const auto within = [](const Measures& m) { return m.free_within_share; };
      add("<tr><td>" + title + "</td><td>" + shell::html_escaped(kind) + "</td>" +
          cell([](const Measures& m) { return m.combined.mean_m; }, 2) +
          cell([](const Measures& m) { return m.combined.avatar_mean_m; }, 2) +
          cell([](const Measures& m) { return m.combined.body_mean_m; }, 2) +
          cell([](const Measures& m) { return m.thirds_m[2]; }, 2) +
          cell([](const Measures& m) { return m.combined.p99_m; }, 2) +
          cell([](const Measures& m) { return m.combined.peak_m; }, 2) +
          cell([](const Measures& m) { return m.body_peak_m; }, 2) + "<td>" +
          percent(mean_of(over_cases(plan_, results_, s.id, within, kind))) + "</td>" +
          cell([](const Measures& m) { return m.updates_per_min; }, 0) +
          cell([](const Measures& m) { return m.kbps; }, 2) + "</tr>");
      title.clear();
    }
  }
  add("</table></div><details><summary>The runs of the first case</summary>");
  for (const Setting& s : plan_.settings)
    add("<p class=\"small\"><code>" +
        shell::html_escaped(run_command(plan_.cases[0], s, plan_.scenario, plan_.netem_text, plan_.ticks)) +
        "</code></p>");
  add("</details>");
}

void Page::causes_table() {
  std::string head = "<div class=\"wide\" tabindex=\"0\"><table><tr><th>updates a minute by cause</th>";
  for (const std::string_view cause : sync::kCauseNames) {
    std::string name(cause);
    for (char& c : name)
      if (c == '_') c = ' ';
    head += "<th>" + name + "</th>";
  }
  add(head + "</tr>");
  const double minutes = plan_.seconds() / 60 * static_cast<double>(plan_.cases.size());
  for (std::size_t k = 0; k < plan_.settings.size(); ++k) {
    std::string row = "<tr><td>" + shell::html_escaped(plan_.settings[k].title) + "</td>";
    for (std::size_t cause = 0; cause < sync::kCauses; ++cause) {
      std::uint64_t sum = 0;
      for (const std::vector<FigureRun>& of_case : results_.runs) sum += of_case[k].updates_by_cause[cause];
      row += "<td>" + fixed(static_cast<double>(sum) / minutes, 0) + "</td>";
    }
    add(row + "</tr>");
  }
  add("</table></div>");
}

void Page::predictors_table() {
  add("<div class=\"wide\" tabindex=\"0\"><table><tr><th>predictor</th><th>warnings</th><th>came true</th><th>did "
      "not</th><th>contacts</th>"
      "<th>foreseen</th><th>by (s)</th><th>free time under warning</th><th>updates a minute</th></tr>");
  for (const char* predictor : kPredictors) {
    const PredictionScore s = score_of(plan_, results_, adaptive_id(predictor));
    const auto updates = [](const Measures& m) { return m.updates_per_min; };
    add(std::string("<tr><td>") + predictor + "</td><td>" + std::to_string(s.right + s.wrong) + "</td><td>" +
        percent(s.precision()) + "</td><td>" + percent(1 - s.precision()) + "</td><td>" +
        std::to_string(s.foreseen + s.unforeseen) + "</td><td>" + percent(s.recall()) + "</td><td>" +
        fixed(s.lead_s(), 2) + "</td><td>" + percent(s.warned_share()) + "</td><td>" +
        fixed(mean_of(over_cases(plan_, results_, adaptive_id(predictor), updates)), 0) + "</td></tr>");
  }
  add("</table></div>");
}

void Page::cases_table() {
  std::string head = "<div class=\"wide\" tabindex=\"0\"><table><tr><th>peak, m (updates a minute)</th>";
  for (const Case& c : plan_.cases) head += "<th>" + shell::html_escaped(c.title) + "</th>";
  add(head + "</tr>");
  for (std::size_t k = 0; k < plan_.settings.size(); ++k) {
    std::string row = "<tr><td>" + shell::html_escaped(plan_.settings[k].title) + "</td>";
    for (const std::vector<Measures>& of_case : results_.measures)
      row += "<td>" + fixed(of_case[k].combined.peak_m, 2) + " (" + fixed(of_case[k].updates_per_min, 0) + ")</td>";
    add(row + "</tr>");
  }
  add("</table></div>");
}

std::string Page::text() {
  head();
  add("<h2>Everything at a glance</h2>");
  picture("drift", "Mean of all cases, and their range");
  picture("peaks", "What peaks cost: means of all cases");
  settings_table();
  add("<h2>Figure 6: the path</h2><p>Where the avatar went, among the bodies as they stood at the start and at the "
      "end; a dot is where it begins to touch a body.</p>");
  pictures_of("6");
  add("<h2>Figure 7: no authority over bodies</h2>");
  claims_of("7");
  pictures_of("7");
  add("<h2>Figure 8: dynamic authority, fixed thresholds</h2>");
  claims_of("8");
  pictures_of("8");
  add("<h2>Figure 9: dynamic authority, adaptive threshold</h2>");
  claims_of("9");
  pictures_of("9");
  add("<h2>How many updates it took</h2><p>The paper gives no numbers. Of entity updates, each counted once:</p>");
  causes_table();
  cases_table();
  add("<h2>How often a predicted contact did not happen</h2><p>The paper names false predictions as the weakness of "
      "its technique, without numbers. A warning is a stretch of time during which interaction is predicted and the "
      "avatar touches nothing; it came true if the avatar touched a body before its end or within the " +
      std::to_string(plan_.settings.back().technique.steps) +
      " ticks of the look-ahead after it. A contact counts if there was none for 0.25 s before; it was foreseen if a "
      "warning stood at the tick before. pcc predicts a cost in metres rather than a contact, so that contacts that "
      "cost nothing are none of its business.</p>");
  picture("prediction", "Predictions of contacts, all cases");
  predictors_table();
  return out_ + "</main>\n</body>\n</html>\n";
}

}  // namespace

std::string html(const std::string& dir, const Plan& plan, const Results& results, const std::vector<Claim>& claims,
                 bool pictures) {
  return Page(dir, plan, results, claims, pictures).text();
}

}  // namespace padr::lab::figures
