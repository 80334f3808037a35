#pragma once
/// Results go to stdout, messages to stderr.

#include <chrono>
#include <cstddef>
#include <string>
#include <vector>

namespace balance::app {

/// Opens those of stdin, stdout and stderr that are closed, so that no file opened later takes their descriptors. Call
/// it first.
void reserve_standard_descriptors();

/// Writes a result to stdout and flushes. @throws SystemError if this fails (full disk, closed descriptor)
void print(const std::string& text);

/// The same for text that people read: escapes invisible characters, so that file contents cannot control the terminal.
void print_text(const std::string& text);

/// Prints the escaped status of a run that wrote files: to stdout, or to stderr if stdout received one of the files.
void print_status(const std::vector<std::string>& files, const std::string& text);

/// "written: a.h5" and a line feed; empty for standard output.
std::string format_written_message(const std::string& file, const std::string& what = "written");

/// Writes one line to stderr, escaped, including line feeds. Write errors are ignored.
void print_message(const std::string& text);

/// The same for a text of several lines; keeps line feeds.
void print_message_lines(const std::string& text);

/// Columns for text on stdout: those of the terminal if it is wider than 80; otherwise 80.
std::size_t text_width();

/// Progress on stderr during long computations: one line that is overwritten. Only on a terminal.
class ProgressLine {
 public:
  explicit ProgressLine(bool quiet);
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  /// Draws the text immediately.
  void draw(const std::string& text);

  /// Draws "what: 43 %", at most once a second and not during the first second.
  void draw_fraction(const std::string& what, double fraction);

 private:
  const bool is_shown_;
  bool is_drawn_ = false;
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

}  // namespace balance::app
