#include "balance/foundation/base/error.hpp"

#include "balance/foundation/base/unicode_text.hpp"

#include <utility>

namespace balance {
namespace {

/// @param listed number of mistakes listed individually
std::string format_unlisted_count(std::size_t listed, std::size_t more) {
  const bool limit_reached = listed + more >= SpecError::max_counted_diagnostics;
  return std::string("and ") + (limit_reached ? "at least " : "") + std::to_string(more) + " more mistake" +
         (more == 1 ? "" : "s");
}

std::string format_diagnostics(const std::vector<Diagnostic>& mistakes, std::size_t more) {
  std::string text;
  for (const Diagnostic& mistake : mistakes) text += (text.empty() ? "" : "\n") + mistake.text();
  return more == 0 ? text : text + "\n" + format_unlisted_count(mistakes.size(), more);
}

std::size_t count_unlisted(std::size_t count) {
  return count > SpecError::max_diagnostics ? count - SpecError::max_diagnostics : 0;
}

std::vector<Diagnostic> take_first_listed(std::vector<Diagnostic> mistakes) {
  if (mistakes.empty()) throw std::invalid_argument("a SpecError needs a mistake");
  if (mistakes.size() > SpecError::max_diagnostics) mistakes.resize(SpecError::max_diagnostics);
  return mistakes;
}

}  // namespace

std::string SourceLocation::text() const {
  std::string location = file;
  if (line > 0) location += ":" + std::to_string(line) + ":" + std::to_string(column);
  if (key.empty()) return location;
  return location.empty() ? key : location + ": " + key;
}

std::string Diagnostic::text() const {
  const std::string location = place.text();
  return escape_for_terminal(location.empty() ? message : location + ": " + message);
}

SpecError::SpecError(Diagnostic mistake) : SpecError(std::vector<Diagnostic>{std::move(mistake)}) {}

SpecError::SpecError(std::vector<Diagnostic> mistakes, std::size_t more)
    : std::runtime_error(format_diagnostics(take_first_listed(mistakes), more + count_unlisted(mistakes.size()))),
      mistakes_(take_first_listed(mistakes)),
      more_(more + count_unlisted(std::exchange(mistakes, {}).size())) {}

std::string SpecError::summary() const {
  const std::size_t others = mistakes_.size() - 1 + more_;
  return mistakes_.front().text() + (others == 0 ? "" : " (" + format_unlisted_count(1, others) + ")");
}

}  // namespace balance
