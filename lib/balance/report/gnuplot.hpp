#pragma once
/// The program gnuplot as a function.

#include <string>

namespace balance {

/// What gnuplot prints when it reads the script. It is found by PATH and started without a shell, its own settings files are
/// not read, and language and time zone are fixed.
/// @throws SystemError if there is no gnuplot, or with what it says if it fails
std::string run_gnuplot(const std::string& script);

}  // namespace balance
