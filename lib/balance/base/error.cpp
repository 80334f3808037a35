#include "balance/base/error.hpp"

#include "balance/base/plain_text.hpp"

#include <utility>

namespace balance {
namespace {

/// @param kept those that are told one by one
std::string counted(std::size_t kept, std::size_t more) {
  const bool stopped = kept + more >= SpecError::most_counted;
  return std::string("and ") + (stopped ? "at least " : "") + std::to_string(more) + " more mistake" +
         (more == 1 ? "" : "s");
}

std::string all_lines(const std::vector<Mistake>& mistakes, std::size_t more) {
  std::string text;
  for (const Mistake& mistake : mistakes) text += (text.empty() ? "" : "\n") + mistake.text();
  return more == 0 ? text : text + "\n" + counted(mistakes.size(), more);
}

std::size_t beyond(std::size_t count) {
  return count > SpecError::most_mistakes ? count - SpecError::most_mistakes : 0;
}

std::vector<Mistake> first_of(std::vector<Mistake> mistakes) {
  if (mistakes.empty()) throw std::invalid_argument("a SpecError needs a mistake");
  if (mistakes.size() > SpecError::most_mistakes) mistakes.resize(SpecError::most_mistakes);
  return mistakes;
}

}  // namespace

std::string SpecPlace::text() const {
  std::string place = file;
  if (line > 0) place += ":" + std::to_string(line) + ":" + std::to_string(column);
  if (key.empty()) return place;
  return place.empty() ? key : place + ": " + key;
}

std::string Mistake::text() const {
  const std::string where = place.text();
  return visible(where.empty() ? message : where + ": " + message);
}

SpecError::SpecError(Mistake mistake) : SpecError(std::vector<Mistake>{std::move(mistake)}) {}

SpecError::SpecError(std::vector<Mistake> mistakes, std::size_t more)
    : std::runtime_error(all_lines(first_of(mistakes), more + beyond(mistakes.size()))),
      mistakes_(first_of(mistakes)),
      more_(more + beyond(std::exchange(mistakes, {}).size())) {}

std::string SpecError::brief() const {
  const std::size_t others = mistakes_.size() - 1 + more_;
  return mistakes_.front().text() + (others == 0 ? "" : " (" + counted(1, others) + ")");
}

}  // namespace balance
