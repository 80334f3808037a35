#include "balance/read/problem.hpp"

#include "balance/base/error.hpp"

#include <fmt/format.h>

#include <tuple>

namespace balance::read {

namespace {
constexpr int enough = 100;
}

Problems Problems::of_option(std::string name) {
  Problems problems(std::move(name));
  problems.is_option_ = true;
  return problems;
}

void Problems::add(Problem problem) {
  const auto key = [](const Problem& p) { return std::tuple(p.place.line, p.place.column); };
  if (!first_ || key(problem) < key(*first_)) first_ = std::move(problem);
  if (++count_ >= enough) throw_first();
}

void Problems::throw_first() const {
  if (!first_) return;
  const std::string where = is_option_ ? file_ + ": "
                            : first_->place.line > 0
                                ? fmt::format("{}:{}:{}: ", file_, first_->place.line, first_->place.column)
                                : "";
  const std::string path = first_->path.empty() ? "" : first_->path + ": ";
  throw SpecError(where + path + first_->text);
}

}  // namespace balance::read
