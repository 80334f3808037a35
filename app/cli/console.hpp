#pragma once
/// Results go to stdout, messages to stderr.

#include <chrono>
#include <string>
#include <vector>

namespace balance::app {

/// Makes sure that no file that is opened later can be mistaken for stdin, stdout or stderr. Call it first.
void reserve_standard_descriptors();

/// Writes a result to stdout at once. @throws SystemError if it does not arrive (full disk, closed descriptor)
void print(const std::string& text);

/// The same for people: what cannot be seen is spelt out, so that nothing in a file can steer a terminal.
void print_text(const std::string& text);

/// What is told of a run that wrote files: on stdout, or on stderr where stdout took one of them. Spelt out like that.
void print_status(const std::vector<std::string>& files, const std::string& text);

/// "written: a.h5" and a line feed; nothing for standard output.
std::string format_written_message(const std::string& file, const std::string& what = "written");

/// Writes one line to stderr, spelt out like that, line feeds too. A message that cannot be delivered is lost.
void print_message(const std::string& text);

/// The same for a text of several lines.
void tell_lines(const std::string& text);

/// One line on stderr that is written over and over while something takes long; on a terminal only.
class ProgressLine {
 public:
  explicit ProgressLine(bool quiet);
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  /// Draws the text at once.
  void draw(const std::string& text);

  /// "what: 43 %", once a second at most, not in the first one.
  void draw_fraction(const std::string& what, double part);

 private:
  const bool shown_;
  bool drawn_ = false;
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

}  // namespace balance::app
