#pragma once
/// Three kinds of failure: an invalid spec throws SpecError, a failing file or system call throws SystemError, misuse
/// of the library throws std::invalid_argument. An unfavourable result (unreachable, singular) is not an error: it is
/// returned as a status with its reason.

#include <cstddef>
#include <stdexcept>
#include <string>
#include <vector>

namespace balance {

/// A location in a spec, a suite or an option.
struct SourceLocation {
  std::string file;  ///< as the user named it; for an option its name, `--minimize`
  int line = 0;      ///< from 1; 0 if there is no specific location
  int column = 0;    ///< from 1, in characters
  std::string key;   ///< `bodies.lower.mass`; empty: the whole file

  bool is_option() const { return file.starts_with("--") && line == 0; }
  /// `arm.yaml:12:17: bodies.lower.mass`, as far as known.
  std::string text() const;
};

/// One mistake in a spec.
struct Diagnostic {
  SourceLocation place;
  std::string message;   ///< the whole sentence: `must be positive: expected a number > 0, found -1`
  std::string expected;  ///< `a number > 0`; empty if the message already covers it, like the next two members
  std::string found;     ///< `-1`
  std::string hint;      ///< `nearest is 'upper'`

  /// One line: `arm.yaml:12:17: bodies.lower.mass: must be positive: expected a number > 0, found -1`. Invisible
  /// characters are escaped.
  std::string text() const;
};

/// The spec is invalid. what() has one line for each mistake kept and, if there are more, a line with their number.
class SpecError : public std::runtime_error {
 public:
  /// Maximum number of mistakes kept; they are the first ones.
  static constexpr std::size_t max_diagnostics = 20;
  /// Reading stops at this many mistakes; the number of further ones is then unknown.
  static constexpr std::size_t max_counted_diagnostics = 100;

  explicit SpecError(Diagnostic mistake);
  /// @param mistakes in the order of the document, at least one
  /// @param more number of further mistakes
  explicit SpecError(std::vector<Diagnostic> mistakes, std::size_t more = 0);

  const std::vector<Diagnostic>& diagnostics() const { return mistakes_; }
  /// Number of mistakes besides diagnostics().
  std::size_t unlisted_count() const { return more_; }
  /// One line: the first mistake and the number of further ones.
  std::string summary() const;

 private:
  std::vector<Diagnostic> mistakes_;
  std::size_t more_ = 0;
};

/// A file cannot be read or written, or a system call fails.
class SystemError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace balance
