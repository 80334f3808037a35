#pragma once
/// Three kinds of trouble, three ways out: a wrong spec throws SpecError, a failing file or system throws
/// SystemError, misuse of the library throws std::invalid_argument. An unwelcome answer (unreachable, singular)
/// is not an error: it is returned as a status with its reason.

#include <stdexcept>
#include <string>

namespace balance {

/// The spec is wrong. The message reads `file:line:column: key.path: what was expected, what was found`.
class SpecError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A file cannot be read or written, or the system refuses something.
class SystemError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace balance
