#pragma once
/// Three kinds of trouble, three ways out: a wrong spec throws SpecError, a failing file or system throws
/// SystemError, misuse of the library throws std::invalid_argument. An unwelcome answer (unreachable, singular)
/// is not an error: it is returned as a status with its reason.

#include <cstddef>
#include <stdexcept>
#include <string>
#include <vector>

namespace balance {

/// Where something is said in a spec, a suite or an option.
struct SourceLocation {
  std::string file;  ///< as the user named it; of an option its name, `--minimize`
  int line = 0;      ///< from 1; 0: what is meant has no place of its own
  int column = 0;    ///< from 1, in characters
  std::string key;   ///< `bodies.lower.mass`; empty: the whole file

  bool is_option() const { return file.starts_with("--") && line == 0; }
  /// `arm.yaml:12:17: bodies.lower.mass`, as much of it as there is.
  std::string text() const;
};

/// One thing that is wrong with a spec.
struct Diagnostic {
  SourceLocation place;
  std::string message;   ///< the whole sentence: `must be positive: expected a number > 0, found -1`
  std::string expected;  ///< `a number > 0`; empty where the message says it in its own way, like the next two
  std::string found;     ///< `-1`
  std::string hint;      ///< `nearest is 'upper'`

  /// One line: `arm.yaml:12:17: bodies.lower.mass: must be positive: expected a number > 0, found -1`; what cannot be seen is spelt
  /// out.
  std::string text() const;
};

/// The spec is wrong. what() has a line for each mistake and, if there are more than are kept, one that counts those.
class SpecError : public std::runtime_error {
 public:
  /// The first so many are kept.
  static constexpr std::size_t max_diagnostics = 20;
  /// Reading ends at so many; from there on it is not known how many more there are.
  static constexpr std::size_t max_counted_diagnostics = 100;

  explicit SpecError(Diagnostic mistake);
  /// @param mistakes in the order of the document, at least one
  /// @param more how many there are besides these
  explicit SpecError(std::vector<Diagnostic> mistakes, std::size_t more = 0);

  const std::vector<Diagnostic>& diagnostics() const { return mistakes_; }
  /// How many there are besides mistakes().
  std::size_t unlisted_count() const { return more_; }
  /// One line: the first mistake, and how many follow.
  std::string summary() const;

 private:
  std::vector<Diagnostic> mistakes_;
  std::size_t more_ = 0;
};

/// A file cannot be read or written, or the system refuses something.
class SystemError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace balance
