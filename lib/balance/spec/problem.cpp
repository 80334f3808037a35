#include "balance/spec/problem.hpp"

#include <algorithm>
#include <stdexcept>
#include <tuple>

namespace balance::read {

namespace {

constexpr std::size_t enough = SpecError::most_counted;

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

std::string Complaint::text() const {
  if (!message.empty()) return message;
  std::string text = kind;
  if (!expected.empty()) text += (text.empty() ? "" : ": ") + std::string("expected ") + expected;
  if (!found.empty()) text += ", found " + found;
  if (!hint.empty()) text += "; " + hint;
  return text;
}

Problems Problems::of_option(std::string name) {
  Problems problems(std::move(name));
  problems.is_option_ = true;
  return problems;
}

int Problems::add_file(std::string name) {
  files_.push_back(std::move(name));
  return static_cast<int>(files_.size()) - 1;
}

void Problems::add(Problem problem) {
  ++failures_;
  spoilt_.insert(problem.about);
  // What is wrong in a part is told of the first of its copies.
  const bool again = std::any_of(all_.begin(), all_.end(), [&](const Problem& one) {
    return one.place.line == problem.place.line && one.place.column == problem.place.column &&
           one.place.file == problem.place.file && (one.path == problem.path || one.place.file > 0) &&
           one.what_is_wrong.text() == problem.what_is_wrong.text();
  });
  if (again) return;
  if (problem.odd_in) misspelt_.insert(*problem.odd_in);
  all_.push_back(std::move(problem));
  if (all_.size() >= enough) throw_all();
}

bool Problems::lost(const std::string& path) const {
  for (std::string above = path; !above.empty(); above = parent_of(above))
    if (spoilt_.count(above) > 0) return true;
  return misspelt_.count(parent_of(path)) > 0;
}

bool Problems::spoilt(const std::string& path) const {
  for (std::string above = path; !above.empty(); above = parent_of(above))
    if (spoilt_.count(above) > 0) return true;
  const auto below = spoilt_.lower_bound(path);
  return std::any_of(below, spoilt_.end(), [&](const std::string& one) { return is_below(one, path); });
}

bool Problems::doubtful(const std::string& path) const { return spoilt(path) || misspelt_.count(parent_of(path)) > 0; }

void Problems::throw_all() const {
  if (none()) return;
  if (all_.empty()) throw std::logic_error("a consequence without a mistake");
  std::vector<const Problem*> ordered;
  for (const Problem& problem : all_) ordered.push_back(&problem);
  const auto key = [](const Problem* p) { return std::tuple(p->place.file, p->place.line, p->place.column); };
  std::stable_sort(ordered.begin(), ordered.end(), [&](auto* a, auto* b) { return key(a) < key(b); });
  std::vector<Mistake> mistakes;
  for (const Problem* one : ordered) {
    const Complaint& wrong = one->what_is_wrong;
    Mistake mistake{{file_of(one->place), one->place.line, one->place.column, one->path},
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

}  // namespace balance::read
