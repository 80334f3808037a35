#pragma once
/// Everything that is wrong with one spec. Sections are read on after a mistake, so that the message is about the
/// mistake that comes first in the document, not about the one that happened to be looked at first.

#include <exception>
#include <optional>
#include <string>
#include <utility>

namespace balance::read {

/// A place in the spec, counted from one; line 0 is outside of the file (the command line).
struct Place {
  int line = 0;
  int column = 0;
};

/// One mistake. Thrown by the readers of values, collected by the readers of mappings.
struct Problem : std::exception {
  Problem(Place where, std::string key_path, std::string what_is_wrong)
      : place(where), path(std::move(key_path)), text(std::move(what_is_wrong)) {}
  const char* what() const noexcept override { return text.c_str(); }

  Place place;
  std::string path;
  std::string text;
};

class Problems {
 public:
  explicit Problems(std::string file) : file_(std::move(file)) {}
  /// Of an option's value, where lines and columns say nothing.
  static Problems of_option(std::string name);

  /// @throws SpecError once there are so many that reading on is pointless
  void add(Problem problem);
  bool none() const { return !first_; }
  int count() const { return count_; }
  /// @throws SpecError if there is any
  void throw_first() const;

  /// Runs `read` and keeps its Problem. @return whether there was none
  template <class Read>
  bool guard(Read&& read) {
    const int before = count_;
    try {
      read();
    } catch (Problem& problem) {
      add(std::move(problem));
    }
    return count_ == before;
  }

 private:
  std::string file_;
  bool is_option_ = false;
  std::optional<Problem> first_;  ///< in the document
  int count_ = 0;
};

}  // namespace balance::read
