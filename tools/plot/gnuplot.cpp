#include "tools/plot/gnuplot.h"

#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cctype>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <system_error>

#include "common/model/user_error.h"
#include "shell/files.h"

namespace padr::plot {
namespace {

constexpr int kCannotRun = 127;

/// Exit status of `gnuplot SCRIPT` in `dir`; kCannotRun if there is no gnuplot.
int run_gnuplot(const std::string& dir, const std::string& file) {
  const pid_t child = fork();
  if (child < 0) throw std::system_error(errno, std::generic_category(), "fork");
  if (child == 0) {
    if (chdir(dir.c_str()) == 0) execlp("gnuplot", "gnuplot", file.c_str(), static_cast<char*>(nullptr));
    _exit(kCannotRun);
  }
  int status = 0;
  while (waitpid(child, &status, 0) < 0)
    if (errno != EINTR) throw std::system_error(errno, std::generic_category(), "waitpid");
  return WIFEXITED(status) ? WEXITSTATUS(status) : 1;
}

void remove_pictures(const std::string& dir, const std::string& name) {
  std::error_code ignored;
  for (const char* kind : {".svg", ".png"})
    std::filesystem::remove(std::filesystem::path(dir) / (name + kind), ignored);
}

std::string settings(std::string_view separator) {
  return "set encoding utf8\nset datafile missing '?'\nset datafile separator " + std::string(separator) +
         "\nset style line 100 lc rgb '#DDDDDD' lw 0.7\nset grid back ls 100\nset tics nomirror out\nset border 3\n"
         "set key outside right top vertical Left reverse noenhanced samplen 2\n";
}

/// Elements of the SVG are named after the picture, so that several of them can stand in one page.
std::string identifier(std::string name) {
  for (char& c : name)
    if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
  return name;
}

}  // namespace

NamedText script(const std::string& name, const Canvas& c, const std::string& body, std::string_view separator) {
  const std::string font = " font 'sans," + std::to_string(c.font);
  // The two terminals draw points of different sizes: `mark` evens that out.
  std::string s = settings(separator) + "mark = 0.6\n";
  s += "set terminal svg size " + std::to_string(c.width) + "," + std::to_string(c.height) + " dynamic name " +
       in_quotes(identifier(name)) + font + "' background '#FFFFFF'\nset output " + in_quotes(name + ".svg") + "\n" +
       body + "set output\nreset session\n";
  s += settings(separator) + "mark = 1\n";
  s += "set terminal pngcairo size " + std::to_string(c.width * 3 / 2) + "," + std::to_string(c.height * 3 / 2) + font +
       "' fontscale 1.1 linewidth 1.5 background '#FFFFFF'\nset output " + in_quotes(name + ".png") + "\n" + body +
       "set output\n";
  return {name + ".gp", s};
}

std::string in_quotes(std::string_view text) {
  std::string s = "'";
  for (const char c : text) s += c == '\'' ? "''" : std::string(1, c);
  return s + "'";
}

std::string number(double v, int digits) {
  if (!std::isfinite(v)) return "?";
  std::array<char, 64> text{};
  const auto r = std::to_chars(text.data(), text.data() + text.size(), v, std::chars_format::general, digits);
  return {text.data(), r.ptr};
}

void write_into(std::string_view flag, const std::string& dir, const std::vector<NamedText>& files) {
  std::error_code error;
  std::filesystem::create_directories(dir, error);
  if (error) throw UserError(std::string(flag) + ": cannot make '" + dir + "': " + error.message());
  for (const NamedText& f : files) {
    shell::OutputFile out(flag, (std::filesystem::path(dir) / f.name).string());
    out.write(f.text);
    out.close();
  }
}

Drawing draw(const std::string& dir, const std::vector<std::string>& names) {
  for (const std::string& name : names) remove_pictures(dir, name);
  for (const std::string& name : names) {
    const int status = run_gnuplot(dir, name + ".gp");
    if (status == kCannotRun)
      return {"no gnuplot, so no plots: install it (sudo apt-get install gnuplot-nox), then run gnuplot *.gp in " +
              dir};
    if (status == 0) continue;
    remove_pictures(dir, name);  // half of one may be there
    return {"gnuplot failed on " + (std::filesystem::path(dir) / (name + ".gp")).string(), true};
  }
  return {};
}

}  // namespace padr::plot
