#include "balance/interface/specification/balanced_spec.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <stdexcept>
#include <string_view>

namespace balance::specification {

using study::TextReplacement;

namespace {

/// The shortest text that reads back to the same double. A number such as 1e5 gets a point, without
/// which YAML 1.1 sees no number.
std::string shortest_text(double value) {
  std::array<char, 32> buffer{};
  const auto [end, error] = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value == 0 ? 0.0 : value);
  std::string text(buffer.data(), end);
  const auto exponent = text.find('e');
  if (exponent != std::string::npos && text.find('.') == std::string::npos) text.insert(exponent, ".0");
  return text;
}

/// The number whose product with `unit` is the value, or nearest to it. Of several, the shortest.
std::string number_text(double value, double unit) {
  if (unit == 1) return shortest_text(value);
  double candidate = value / unit;
  for (int step = 0; step < 2; ++step) candidate = std::nextafter(candidate, -INFINITY);
  std::string best;
  double best_error = INFINITY;
  for (int step = 0; step < 5; ++step, candidate = std::nextafter(candidate, INFINITY)) {
    const double error = std::abs(candidate * unit - value);
    const std::string text = shortest_text(candidate);
    if (error < best_error || (error == best_error && text.size() < best.size())) {
      best = text;
      best_error = error;
    }
  }
  return best;
}

/// Cuts out the elements that are left out, with all rewrites inside them.
std::vector<TextReplacement> cut_omitted_elements(const std::vector<TextReplacement>& rewrites,
                                                  const std::vector<study::OptionalElementText>& omitted_elements) {
  std::vector<TextReplacement> replacements;
  const auto is_omitted = [&](const TextReplacement& rewrite) {
    return std::any_of(
        omitted_elements.begin(), omitted_elements.end(), [&](const study::OptionalElementText& element) {
          return element.begin <= rewrite.begin && rewrite.begin < element.end && rewrite.end <= element.end;
        });
  };
  for (const TextReplacement& rewrite : rewrites)
    if (!is_omitted(rewrite)) replacements.push_back(rewrite);
  for (const study::OptionalElementText& element : omitted_elements)
    if (element.begin < element.end) replacements.push_back({element.begin, element.end, "", -1});
  std::stable_sort(replacements.begin(), replacements.end(),
                   [](const TextReplacement& a, const TextReplacement& b) { return a.begin < b.begin; });
  return replacements;
}

}  // namespace

std::string format_balanced_spec(const Study& study, const VectorX& x, const std::vector<std::string>& expressions,
                                 const std::vector<study::OptionalElementText>& omitted_elements) {
  const std::size_t count = study.free_numbers.size();
  if (x.size() != static_cast<Eigen::Index>(count))
    throw std::invalid_argument(fmt::format("expected {} values of free numbers, found {}", count, x.size()));
  if (!expressions.empty() && expressions.size() != count)
    throw std::invalid_argument(fmt::format("expected {} expressions, found {}", count, expressions.size()));
  if (!x.allFinite()) throw std::invalid_argument("expected finite values of the free numbers");
  const std::string_view spec = study.spec_text;
  std::string text;
  std::size_t copied_end = 0;
  for (const TextReplacement& rewrite : cut_omitted_elements(study.rewrites, omitted_elements)) {
    text += spec.substr(copied_end, rewrite.begin - copied_end);
    text += rewrite.text;
    if (rewrite.free_number >= 0 && !expressions.empty() &&
        !expressions[static_cast<std::size_t>(rewrite.free_number)].empty())
      text += expressions[static_cast<std::size_t>(rewrite.free_number)];
    else if (rewrite.free_number >= 0)
      text +=
          number_text(x[rewrite.free_number], study.free_numbers[static_cast<std::size_t>(rewrite.free_number)].unit);
    copied_end = rewrite.end;
  }
  text += spec.substr(copied_end);
  return text;
}

}  // namespace balance::specification
