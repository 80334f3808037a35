#pragma once
/// One line on stderr that is written over and over while something takes long; on a terminal only.

#include <chrono>
#include <string>

namespace balance::app {

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
