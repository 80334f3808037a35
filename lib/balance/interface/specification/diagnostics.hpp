#pragma once
/// Collects everything that is wrong with one spec. Reading continues after a mistake, so that all mistakes are
/// reported at once. Consequences of a reported mistake are not reported.

#include "balance/foundation/base/error.hpp"

#include <exception>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace balance::specification {

/// A place in the spec, counted from one. Line 0 is outside of the file: the path is then an option's name.
struct NodeLocation {
  int line = 0;
  int column = 0;
  int file = 0;  ///< 0: the spec's own; else the result of SpecErrorCollector::add_file() for a part's
};

/// What is wrong, in parts: `kind: expected …, found …; hint`, as far as given.
struct ErrorMessage {
  std::string message;   ///< the whole sentence, if it does not consist of the parts
  std::string kind;      ///< "must be positive", "missing key"
  std::string expected;  ///< "a number > 0"
  std::string found;     ///< "-1"
  std::string hint;      ///< "nearest is 'upper'"

  std::string text() const;
};

/// One mistake. Thrown by the readers of values, collected by the readers of mappings.
struct ReadError : std::exception {
  ReadError(NodeLocation where, std::string key_path, ErrorMessage error_message)
      : place(where), path(std::move(key_path)), message(std::move(error_message)), subject_path(path) {}
  const char* what() const noexcept override { return path.c_str(); }

  NodeLocation place;
  std::string path;
  ErrorMessage message;
  std::string subject_path;                   ///< path of what is missing or invalid
  std::optional<std::string> unknown_key_in;  ///< path of a mapping with an unknown key, which may be a misspelling
};

/// Thrown if something cannot be read because of a mistake elsewhere that is already collected.
struct CascadingError : std::exception {
  const char* what() const noexcept override { return "a mistake elsewhere"; }
};

class SpecErrorCollector {
 public:
  explicit SpecErrorCollector(std::string file) : files_{std::move(file)} {}
  /// Of an option's value, where lines and columns are meaningless.
  static SpecErrorCollector of_option(std::string name);

  /// @throws SpecError once there are so many that reading on is pointless
  void add(ReadError error);
  /// Adds a file that the spec includes. @return its number in places
  int add_file(std::string name);
  /// Takes over the files of another reading, so that its places are valid here.
  void adopt_files(const SpecErrorCollector& other) { files_ = other.files_; }
  /// Name of a place's file in messages.
  const std::string& file_of(const NodeLocation& place) const { return files_[static_cast<std::size_t>(place.file)]; }
  bool is_empty() const { return failures_ == 0; }
  /// @throws SpecError listing all mistakes in document order, if there are any
  void throw_if_any() const;

  /// Notes that the value at a path is unknown.
  void mark_invalid(const std::string& path) { invalid_paths_.insert(path); }
  /// Whether something is wrong with the value at a path, with a part of it or with the whole that contains it.
  bool is_invalid(const std::string& path) const;
  /// Whether something that is missing at a path may exist after all: it is invalid, or its mapping has an unknown key.
  bool is_uncertain(const std::string& path) const;
  /// The same for a whole section, whose parts may be wrong.
  bool is_section_invalid(const std::string& path) const;

  /// Runs `read` and collects its ReadError. @return whether there was neither a mistake nor a consequence of one
  template <class Read>
  bool collect(Read&& read) {
    const int before = failures_;
    try {
      read();
    } catch (ReadError& error) {
      add(std::move(error));
    } catch (const CascadingError&) {
      ++failures_;
    }
    return failures_ == before;
  }

 private:
  std::vector<std::string> files_;  ///< the spec's own first
  bool is_option_ = false;
  std::vector<ReadError> errors_;
  std::set<std::string> invalid_paths_;    ///< paths
  std::set<std::string> has_unknown_key_;  ///< paths of mappings with an unknown key
  int failures_ = 0;
};

}  // namespace balance::specification
