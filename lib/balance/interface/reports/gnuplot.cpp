#include "balance/interface/reports/gnuplot.hpp"
#include "balance/interface/reports/junit.hpp"

#include "balance/foundation/base/error.hpp"
#include "balance/foundation/base/unicode_text.hpp"

#include <fmt/format.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <memory>
#include <string_view>
#include <vector>

namespace balance::reports {
namespace {

void replace_first(std::string& text, std::string_view pattern, const std::string& replacement) {
  const std::size_t position = text.find(pattern);
  if (position != std::string::npos) text.replace(position, pattern.size(), replacement);
}

void replace_all(std::string& text, const std::string& pattern, const std::string& replacement) {
  for (std::size_t position = text.find(pattern); position != std::string::npos;
       position = text.find(pattern, position + replacement.size()))
    text.replace(position, pattern.size(), replacement);
}

/// Name of the picture: its title or, if it has none, its quantities.
std::string name_of(const Plot& picture) {
  if (!picture.title.empty()) return escape_for_terminal(picture.title);  // as it is drawn
  std::string name;
  for (const PlotPanel& panel : picture.panels) name += (name.empty() ? "" : ", ") + panel.name;
  return name;
}

}  // namespace

std::string normalise_svg(std::string svg, const std::string& name, const PlotPage& page) {
  const std::size_t width = svg.find(" width=\""), end = svg.find('\n', width);
  if (width != std::string::npos && end != std::string::npos && width < svg.find("viewBox"))
    svg.replace(width, end - width, fmt::format(" width=\"{:g}mm\" height=\"{:g}mm\"", page.width, page.height));
  replace_first(svg, "<title>Gnuplot</title>", "<title>" + escape_xml(name) + "</title>");
  const std::string generic_family = page.font.find("Mono") != std::string::npos ? "monospace"
                                     : page.font.find("Serif") != std::string::npos || page.font == "Times"
                                         ? "serif"
                                         : "sans-serif";
  const std::string fallback = page.font == "Helvetica" ? "Helvetica, Arial, " : page.font + ", ";
  replace_all(svg, fmt::format("font-family=\"{}\"", page.font),
              fmt::format("font-family=\"{}{}\"", fallback, generic_family));
  return svg;
}

std::string remove_pdf_date(std::string pdf) {
  constexpr std::string_view marker = "/CreationDate (D:", epoch = "19700101000000";
  const std::size_t position = pdf.find(marker);
  if (position == std::string::npos) return pdf;
  // in place, digit by digit: the file contains a table of byte offsets
  for (std::size_t i = 0; i < epoch.size(); ++i) {
    char& digit = pdf[position + marker.size() + i];
    if (!std::isdigit(static_cast<unsigned char>(digit))) break;
    digit = epoch[i];
  }
  return pdf;
}

std::string render_plot(const Plot& picture, const PlotPage& options) {
  const PlotPage page = resolve_page_size(picture, options);
  std::string image = run_gnuplot(gnuplot_script(picture, page));
  if (page.format == PlotFileFormat::svg) return normalise_svg(std::move(image), name_of(picture), page);
  return page.format == PlotFileFormat::pdf ? remove_pdf_date(std::move(image)) : image;
}

namespace {

constexpr rlim_t max_cpu_seconds = 8;  // CPU time; a picture takes a fraction of a second

[[noreturn]] void fail(const std::string& what, int error) {
  throw SystemError(fmt::format("{}: {}", what, std::strerror(error)));
}

/// Temporary file without a name. With files instead of pipes no process waits for another.
class UnnamedFile {
 public:
  UnnamedFile() : file_(std::tmpfile(), &std::fclose) {
    if (!file_) fail("cannot make a temporary file", errno);
  }

  int descriptor() const { return ::fileno(file_.get()); }

  void fill(const std::string& text) {
    const bool written = std::fwrite(text.data(), 1, text.size(), file_.get()) == text.size();
    if (!written || std::fflush(file_.get()) != 0 || std::fseek(file_.get(), 0, SEEK_SET) != 0)
      fail("cannot write a temporary file", errno);
  }

  std::string read() {
    std::rewind(file_.get());
    std::string text;
    std::array<char, 1 << 16> block;
    while (const std::size_t count = std::fread(block.data(), 1, block.size(), file_.get()))
      text.append(block.data(), count);
    if (std::ferror(file_.get())) fail("cannot read a temporary file", errno);
    return text;
  }

 private:
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file_;
};

/// Environment of this process without variables that could change the picture.
std::vector<std::string> environment() {
  std::vector<std::string> variables = {"LC_ALL=C.UTF-8", "TZ=UTC0"};
  for (char** entry = environ; entry && *entry; ++entry) {
    const std::string_view text = *entry;
    bool is_dropped = false;
    for (const char* prefix : {"LC_", "LANG", "TZ=", "GNUTERM", "GNUPLOT_"})
      is_dropped = is_dropped || text.starts_with(prefix);
    if (!is_dropped) variables.emplace_back(text);
  }
  return variables;
}

pid_t start(const UnnamedFile& in, const UnnamedFile& out, const UnnamedFile& err) {
  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawn_file_actions_adddup2(&actions, in.descriptor(), STDIN_FILENO);
  ::posix_spawn_file_actions_adddup2(&actions, out.descriptor(), STDOUT_FILENO);
  ::posix_spawn_file_actions_adddup2(&actions, err.descriptor(), STDERR_FILENO);
  std::vector<std::string> arguments = {"gnuplot", "--default-settings"}, variables = environment();
  const auto pointers = [](std::vector<std::string>& texts) {
    std::vector<char*> result;
    for (std::string& text : texts) result.push_back(text.data());
    result.push_back(nullptr);
    return result;
  };
  pid_t child = 0;
  const int error =
      ::posix_spawnp(&child, "gnuplot", &actions, nullptr, pointers(arguments).data(), pointers(variables).data());
  ::posix_spawn_file_actions_destroy(&actions);
  if (error == ENOENT || error == EACCES || error == ENOTDIR)
    throw SystemError("gnuplot, which draws the pictures, is not in PATH; on Debian: apt install gnuplot-nox");
  if (error != 0) fail("cannot start gnuplot", error);
  // numbers from untrusted files may keep it running forever
  const rlimit time{max_cpu_seconds, max_cpu_seconds + 1};
  ::prlimit(child, RLIMIT_CPU, &time, nullptr);
  return child;
}

int wait_for(pid_t child) {
  int status = 0;
  while (::waitpid(child, &status, 0) < 0)
    if (errno != EINTR) fail("cannot wait for gnuplot", errno);
  return status;
}

/// Its message on one line.
std::string join_error_lines(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < 0x20; }, ' ');
  const std::size_t begin = std::min(text.find_first_not_of(' '), text.size());
  return text.substr(begin, 400);
}

}  // namespace

std::string run_gnuplot(const std::string& script) {
  UnnamedFile in, out, err;
  in.fill(script);
  const int status = wait_for(start(in, out, err));
  if (WIFSIGNALED(status) && WTERMSIG(status) == SIGXCPU)
    throw SystemError(fmt::format("gnuplot was stopped: it took longer than {} s", max_cpu_seconds));
  if (WIFSIGNALED(status)) throw SystemError(fmt::format("gnuplot was stopped by signal {}", WTERMSIG(status)));
  if (WEXITSTATUS(status) != 0)
    throw SystemError(
        fmt::format("gnuplot failed (exit code {}): {}", WEXITSTATUS(status), join_error_lines(err.read())));
  std::string picture = out.read();
  if (picture.empty()) throw SystemError("gnuplot drew nothing: " + join_error_lines(err.read()));
  return picture;
}

}  // namespace balance::reports
