#pragma once
/// What a shell may offer where an option's value is typed. It is kept in the parser's own definition of the option, so
/// that completion cannot disagree with what is parsed.

#include <CLI/CLI.hpp>

#include <string>
#include <vector>

namespace balance::app {

struct ValueCompletion {
  enum class Kind { nothing, words, files };
  Kind kind = Kind::nothing;
  std::vector<std::string>
      items;  ///< the words; or the suffixes of the files, such as "yaml": any file if there are none
};

/// Offers words of a fixed set. The option still accepts every text: its command says best what is wrong with another.
void suggest_words(CLI::Option* option, const std::vector<std::string>& words);

/// Offers files with these suffixes (without the dot); any file if there are none.
void suggest_files(CLI::Option* option, const std::vector<std::string>& suffixes);

/// What was suggested; else, by the name of the value, `SPEC`: *.yaml and *.yml, `RESULT`: *.h5, `FILE`: any file.
ValueCompletion find_value_completion(CLI::Option& option);

}  // namespace balance::app
