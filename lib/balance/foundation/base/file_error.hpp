#pragma once
#include "balance/foundation/base/error.hpp"

#include <string>

namespace balance {

/// A file cannot be read or written, for a reason that the system has a number for: ENOENT, EACCES, EISDIR, …
class FileError : public SystemError {
 public:
  /// @param error_number one of the constants of <cerrno>
  FileError(const std::string& message, int error_number) : SystemError(message), error_number_(error_number) {}

  int error_number() const { return error_number_; }

 private:
  int error_number_;
};

}  // namespace balance
