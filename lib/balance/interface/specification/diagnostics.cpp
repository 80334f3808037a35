#include "balance/interface/specification/diagnostics.hpp"

#include <algorithm>
#include <stdexcept>
#include <tuple>

namespace balance::specification {

namespace {

constexpr std::size_t max_diagnostics = SpecError::max_counted_diagnostics;

bool is_below(const std::string& path, const std::string& above) {
  return path.starts_with(above) &&
         (path.size() == above.size() || path[above.size()] == '.' || path[above.size()] == '[');
}

/// `bodies` of `bodies.upper`, nothing of `bodies`.
std::string parent_of(const std::string& path) {
  const auto end = path.find_last_of(".[");
  return end == std::string::npos ? "" : path.substr(0, end);
}

}  // namespace

std::string ErrorMessage::text() const {
  if (!message.empty()) return message;
  std::string text = kind;
  if (!expected.empty()) text += (text.empty() ? "" : ": ") + std::string("expected ") + expected;
  if (!found.empty()) text += ", found " + found;
  if (!hint.empty()) text += "; " + hint;
  return text;
}

SpecErrorCollector SpecErrorCollector::of_option(std::string name) {
  SpecErrorCollector problems(std::move(name));
  problems.is_option_ = true;
  return problems;
}

int SpecErrorCollector::add_file(std::string name) {
  files_.push_back(std::move(name));
  return static_cast<int>(files_.size()) - 1;
}

void SpecErrorCollector::add(ReadError problem) {
  ++failures_;
  spoilt_.insert(problem.subject_path);
  // What is wrong in a part is told of the first of its copies.
  const bool again = std::any_of(all_.begin(), all_.end(), [&](const ReadError& one) {
    return one.place.line == problem.place.line && one.place.column == problem.place.column &&
           one.place.file == problem.place.file && (one.path == problem.path || one.place.file > 0) &&
           one.message.text() == problem.message.text();
  });
  if (again) return;
  if (problem.unknown_key_in) has_unknown_key_.insert(*problem.unknown_key_in);
  all_.push_back(std::move(problem));
  if (all_.size() >= max_diagnostics) throw_if_any();
}

bool SpecErrorCollector::is_section_invalid(const std::string& path) const {
  for (std::string above = path; !above.empty(); above = parent_of(above))
    if (spoilt_.count(above) > 0) return true;
  return has_unknown_key_.count(parent_of(path)) > 0;
}

bool SpecErrorCollector::is_invalid(const std::string& path) const {
  for (std::string above = path; !above.empty(); above = parent_of(above))
    if (spoilt_.count(above) > 0) return true;
  const auto below = spoilt_.lower_bound(path);
  return std::any_of(below, spoilt_.end(), [&](const std::string& one) { return is_below(one, path); });
}

bool SpecErrorCollector::is_uncertain(const std::string& path) const {
  return is_invalid(path) || has_unknown_key_.count(parent_of(path)) > 0;
}

void SpecErrorCollector::throw_if_any() const {
  if (is_empty()) return;
  if (all_.empty()) throw std::logic_error("a consequence without a mistake");
  std::vector<const ReadError*> ordered;
  for (const ReadError& problem : all_) ordered.push_back(&problem);
  const auto key = [](const ReadError* p) { return std::tuple(p->place.file, p->place.line, p->place.column); };
  std::stable_sort(ordered.begin(), ordered.end(), [&](auto* a, auto* b) { return key(a) < key(b); });
  std::vector<Diagnostic> mistakes;
  for (const ReadError* one : ordered) {
    const ErrorMessage& wrong = one->message;
    Diagnostic mistake{{file_of(one->place), one->place.line, one->place.column, one->path},
                       wrong.text(),
                       wrong.expected,
                       wrong.found,
                       wrong.hint};
    if (is_option_) mistake.place.line = mistake.place.column = 0;
    if (!is_option_ && one->place.line == 0) mistake.place = {.file = one->path};
    mistakes.push_back(std::move(mistake));
  }
  throw SpecError(std::move(mistakes));
}

}  // namespace balance::specification
