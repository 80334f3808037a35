#include "balance/interface/specification/diagnostics.hpp"

#include <algorithm>
#include <stdexcept>
#include <tuple>

namespace balance::specification {

namespace {

constexpr std::size_t max_diagnostics = SpecError::max_counted_diagnostics;

bool is_below(const std::string& path, const std::string& ancestor) {
  return path.starts_with(ancestor) &&
         (path.size() == ancestor.size() || path[ancestor.size()] == '.' || path[ancestor.size()] == '[');
}

/// `bodies` for `bodies.upper`; empty for `bodies`.
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

void SpecErrorCollector::add(ReadError error) {
  ++failures_;
  invalid_paths_.insert(error.subject_path);
  // a mistake in a part is reported for the first of its copies only
  const bool is_duplicate = std::any_of(errors_.begin(), errors_.end(), [&](const ReadError& one) {
    return one.place.line == error.place.line && one.place.column == error.place.column &&
           one.place.file == error.place.file && (one.path == error.path || one.place.file > 0) &&
           one.message.text() == error.message.text();
  });
  if (is_duplicate) return;
  if (error.unknown_key_in) has_unknown_key_.insert(*error.unknown_key_in);
  errors_.push_back(std::move(error));
  if (errors_.size() >= max_diagnostics) throw_if_any();
}

bool SpecErrorCollector::is_section_invalid(const std::string& path) const {
  for (std::string ancestor = path; !ancestor.empty(); ancestor = parent_of(ancestor))
    if (invalid_paths_.count(ancestor) > 0) return true;
  return has_unknown_key_.count(parent_of(path)) > 0;
}

bool SpecErrorCollector::is_invalid(const std::string& path) const {
  for (std::string ancestor = path; !ancestor.empty(); ancestor = parent_of(ancestor))
    if (invalid_paths_.count(ancestor) > 0) return true;
  const auto below = invalid_paths_.lower_bound(path);
  return std::any_of(below, invalid_paths_.end(), [&](const std::string& one) { return is_below(one, path); });
}

bool SpecErrorCollector::is_uncertain(const std::string& path) const {
  return is_invalid(path) || has_unknown_key_.count(parent_of(path)) > 0;
}

void SpecErrorCollector::throw_if_any() const {
  if (is_empty()) return;
  if (errors_.empty()) throw std::logic_error("a consequence without a mistake");
  std::vector<const ReadError*> ordered;
  for (const ReadError& error : errors_) ordered.push_back(&error);
  const auto key = [](const ReadError* p) { return std::tuple(p->place.file, p->place.line, p->place.column); };
  std::stable_sort(ordered.begin(), ordered.end(), [&](auto* a, auto* b) { return key(a) < key(b); });
  std::vector<Diagnostic> diagnostics;
  for (const ReadError* error : ordered) {
    const ErrorMessage& message = error->message;
    Diagnostic diagnostic{{file_of(error->place), error->place.line, error->place.column, error->path},
                          message.text(),
                          message.expected,
                          message.found,
                          message.hint};
    if (is_option_) diagnostic.place.line = diagnostic.place.column = 0;
    if (!is_option_ && error->place.line == 0) diagnostic.place = {.file = error->path};
    diagnostics.push_back(std::move(diagnostic));
  }
  throw SpecError(std::move(diagnostics));
}

}  // namespace balance::specification
