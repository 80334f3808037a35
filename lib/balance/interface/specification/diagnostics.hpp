#pragma once
/// Everything that is wrong with one spec. Sections are read on after a mistake, so that all of them are told at once; what is
/// wrong only because of something that was told already is not.

#include "balance/foundation/base/error.hpp"

#include <exception>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace balance::specification {

/// A place in the spec, counted from one. At line 0 it is outside of the file: the path is then an option's name.
struct NodeLocation {
  int line = 0;
  int column = 0;
  int file = 0;  ///< 0: the spec's own; else what SpecErrorCollector::add_file said of a part's
};

/// What is wrong, in parts: `kind: expected …, found …; hint`, as much of it as there is.
struct ErrorMessage {
  std::string message;   ///< the whole sentence, where it is not made of the parts
  std::string kind;      ///< "must be positive", "missing key"
  std::string expected;  ///< "a number > 0"
  std::string found;     ///< "-1"
  std::string hint;      ///< "nearest is 'upper'"

  std::string text() const;
};

/// One mistake. Thrown by the readers of values, collected by the readers of mappings.
struct ReadError : std::exception {
  ReadError(NodeLocation where, std::string key_path, ErrorMessage complaint)
      : place(where), path(std::move(key_path)), message(std::move(complaint)), subject_path(path) {}
  const char* what() const noexcept override { return path.c_str(); }

  NodeLocation place;
  std::string path;
  ErrorMessage message;
  std::string subject_path;  ///< the path of what is missing or spoilt
  std::optional<std::string>
      unknown_key_in;  ///< the path of a mapping with an odd key: another one may have been meant
};

/// Thrown where something cannot be read because of a mistake elsewhere that is collected already.
struct CascadingError : std::exception {
  const char* what() const noexcept override { return "a mistake elsewhere"; }
};

class SpecErrorCollector {
 public:
  explicit SpecErrorCollector(std::string file) : files_{std::move(file)} {}
  /// Of an option's value, where lines and columns say nothing.
  static SpecErrorCollector of_option(std::string name);

  /// @throws SpecError once there are so many that reading on is pointless
  void add(ReadError problem);
  /// A file that the spec is made of besides its own. @return what its places call it
  int add_file(std::string name);
  /// The files of another reading, whose places are known here, too.
  void adopt_files(const SpecErrorCollector& other) { files_ = other.files_; }
  /// What messages call the file of a place.
  const std::string& file_of(const NodeLocation& place) const { return files_[static_cast<std::size_t>(place.file)]; }
  bool is_empty() const { return failures_ == 0; }
  /// @throws SpecError with all of them in the document's order, if there is any
  void throw_if_any() const;

  /// Notes that nothing can be known of what stands at a path.
  void mark_invalid(const std::string& path) { spoilt_.insert(path); }
  /// Whether something is wrong with what stands at a path: there, in a part of it or with the whole that it is a part of.
  bool is_invalid(const std::string& path) const;
  /// Whether what is missing at a path may be there after all: it is spoilt, or a key of the same mapping is not what was meant.
  bool is_uncertain(const std::string& path) const;
  /// The same of a whole section, whose parts may be wrong.
  bool is_section_invalid(const std::string& path) const;

  /// Runs `read` and keeps its ReadError. @return whether there was none, nor a consequence of one
  template <class Read>
  bool collect(Read&& read) {
    const int before = failures_;
    try {
      read();
    } catch (ReadError& problem) {
      add(std::move(problem));
    } catch (const CascadingError&) {
      ++failures_;
    }
    return failures_ == before;
  }

 private:
  std::vector<std::string> files_;  ///< the spec's own first
  bool is_option_ = false;
  std::vector<ReadError> all_;
  std::set<std::string> spoilt_;           ///< paths
  std::set<std::string> has_unknown_key_;  ///< paths of mappings with an odd key
  int failures_ = 0;
};

}  // namespace balance::specification
