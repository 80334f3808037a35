#include "balance/foundation/base/latex_lines.hpp"

#include <algorithm>
#include <cctype>
#include <string_view>
#include <utility>

namespace balance {

namespace {

constexpr double index_width = 0.7;  ///< of a letter, relative to one on the line

/// Where a formula may be broken: before a sign between terms, or between factors.
struct BreakPoint {
  std::size_t position = 0;
  int depth = 0;  ///< of brackets around it
  bool is_sign = false;
  double width = 0;  ///< of what stands before it
};

/// Reads a formula from left to right.
class LatexMeasure {
 public:
  explicit LatexMeasure(const std::string& latex) : latex_(latex) {}

  /// Break points outside fractions and indices; the last one is the end.
  std::vector<BreakPoint> list_break_points() {
    points_.clear();
    const double width = measure(0, latex_.size(), 1, true);
    points_.push_back({latex_.size(), 0, true, width});
    return points_;
  }

  double width() { return measure(0, latex_.size(), 1, false); }

  /// The first fraction outside indices that is wider than a line, from its backslash to its end; an empty range if
  /// there is none.
  std::pair<std::size_t, std::size_t> find_wide_fraction(double limit) {
    for (std::size_t at = 0; (at = latex_.find("\\frac{", at)) != std::string::npos; ++at) {
      const std::size_t end = find_group_end(find_group_end(at + 5));
      if (measure(at, end, 1, false) > limit) return {at, end};
    }
    return {0, 0};
  }

  /// Behind the brace that closes a group.
  std::size_t find_group_end(std::size_t begin) const {
    int depth = 0;
    for (std::size_t k = begin; k < latex_.size(); ++k) {
      depth += latex_[k] == '{' ? 1 : latex_[k] == '}' ? -1 : 0;
      if (depth == 0) return k + 1;
    }
    return latex_.size();
  }

 private:
  /// @param scale of letters: 1 on the line
  double measure(std::size_t begin, std::size_t end, double scale, bool lists_points) {
    double width = 0;
    int brackets = 0;
    for (std::size_t k = begin; k < end;) {
      const char c = latex_[k];
      if (c == '\\') {
        k = measure_command(k, scale, width);
      } else if ((c == '_' || c == '^') && k + 1 < end && latex_[k + 1] == '{') {
        const std::size_t behind = find_group_end(k + 1);
        width += measure(k + 2, behind - 1, index_width * scale, false);
        k = behind;
      } else if (c == '{') {
        const std::size_t behind = find_group_end(k);
        width += measure(k + 1, behind - 1, scale, false);
        k = behind;
      } else if (c == ' ') {
        const bool is_before_sign = is_relation(k + 1) && k + 2 < end && latex_[k + 2] == ' ';
        const bool is_inseparable =
            k == begin || is_relation(k - 1) || latex_[k - 1] == '/' || latex_.compare(k + 1, 2, "\\,") == 0;
        if (lists_points && !is_inseparable) points_.push_back({k + 1, brackets, is_before_sign, width});
        if (is_before_sign) width += scale;
        ++k;
      } else {
        brackets += c == '(' ? 1 : c == ')' ? -1 : 0;
        width += scale;
        ++k;
      }
    }
    return width;
  }

  std::size_t measure_command(std::size_t k, double scale, double& width) {
    std::size_t end = k + 1;
    while (end < latex_.size() && std::isalpha(static_cast<unsigned char>(latex_[end])) != 0) ++end;
    const std::string command = latex_.substr(k + 1, end - k - 1);
    if (command.empty()) return end + 1;  // a thin space
    if (command == "frac" || command == "tfrac") {
      const double letters = command == "frac" ? scale : index_width * scale;
      const std::size_t middle = find_group_end(end), behind = find_group_end(middle);
      width += std::max(measure(end + 1, middle - 1, letters, false), measure(middle + 1, behind - 1, letters, false));
      return behind;
    }
    const bool is_word = command == "sin" || command == "cos";
    const bool is_invisible = command == "left" || command == "right" || command == "bigl" || command == "bigr" ||
                              command == "mathrm" || command == "mathit" || command == "text" || command == "hat" ||
                              command == "bar" || command == "tilde";
    width += is_word ? 3 * scale : is_invisible ? 0 : scale;
    const bool is_accent = command == "hat" || command == "bar" || command == "tilde";
    return is_accent && end < latex_.size() && latex_[end] == ' ' ? end + 1 : end;
  }

  bool is_relation(std::size_t k) const {
    return k < latex_.size() && (latex_[k] == '+' || latex_[k] == '-' || latex_[k] == '=');
  }

  const std::string& latex_;
  std::vector<BreakPoint> points_;
};

bool has_break(const std::string& latex) { return LatexMeasure(latex).list_break_points().size() > 1; }

/// Fractions wider than a line, which cannot be broken, as quotients in one line.
std::string flatten_wide_fractions(std::string latex, double limit) {
  while (true) {
    LatexMeasure measure(latex);
    const auto [begin, end] = measure.find_wide_fraction(limit);
    if (begin == end) return latex;
    const std::size_t numerator = begin + 5, denominator = measure.find_group_end(numerator);
    const auto in_brackets = [&](const std::string& text) {
      return has_break(text) ? "\\left(" + text + "\\right)" : text;
    };
    const std::string quotient = in_brackets(latex.substr(numerator + 1, denominator - numerator - 2)) + " / " +
                                 in_brackets(latex.substr(denominator + 1, end - denominator - 2));
    const bool has_neighbour = end < latex.size() && latex[end] == ' ' && end + 1 < latex.size() &&
                               latex[end + 1] != '+' && latex[end + 1] != '-';
    latex.replace(begin, end - begin, has_neighbour ? "\\left(" + quotient + "\\right)" : quotient);
  }
}

/// Powers of sums without braces around the sum, which no line break may cross.
std::string open_braced_sums(std::string latex) {
  constexpr std::string_view begin = "{\\left(", end = "\\right)}";
  for (std::size_t at = 0; (at = latex.find(begin, at)) != std::string::npos;) {
    const std::size_t behind = LatexMeasure(latex).find_group_end(at);
    const bool is_power = behind < latex.size() && latex[behind] == '^' && behind >= at + begin.size() + end.size() &&
                          latex.compare(behind - end.size(), end.size(), end) == 0;
    if (is_power) latex.erase(behind - 1, 1).erase(at, 1);
    at += is_power ? 0 : begin.size();
  }
  return latex;
}

std::string with_all_replaced(std::string text, const std::string& what, const std::string& by) {
  for (std::size_t at = 0; (at = text.find(what, at)) != std::string::npos; at += by.size())
    text.replace(at, what.size(), by);
  return text;
}

}  // namespace

std::string with_page_breaks(const std::string& displays) {
  if (displays.find("\\begin{align") == std::string::npos) return displays;
  return "\\begingroup\\allowdisplaybreaks\n" + displays + "\\endgroup\n";
}

double latex_width(const std::string& latex) { return LatexMeasure(latex).width(); }

std::vector<std::string> break_latex(const std::string& formula, double limit) {
  std::string latex = flatten_wide_fractions(formula, limit);
  if (latex_width(latex) > limit) {
    latex = open_braced_sums(std::move(latex));
    // \left and \right belong to one line
    for (const auto& [fitting, fixed] : {std::pair("\\left(", "\\bigl("), std::pair("\\right)", "\\bigr)")})
      latex = with_all_replaced(latex, fitting, fixed);
  }
  const std::vector<BreakPoint> points = LatexMeasure(latex).list_break_points();
  std::vector<std::string> lines;
  std::size_t begin = 0, next = 0;
  double before = 0;
  // signs before factors, outer before inner ones
  const auto is_better = [&](const BreakPoint& a, const BreakPoint& b) {
    if (b.width - before < 0.3 * limit) return a.is_sign >= b.is_sign;
    return a.is_sign != b.is_sign ? a.is_sign : a.depth <= b.depth;
  };
  while (begin < latex.size()) {
    std::size_t chosen = points.size() - 1;
    if (points.back().width - before > limit) {
      chosen = next;
      for (std::size_t k = next; k < points.size() && points[k].width - before <= limit; ++k)
        if (is_better(points[k], points[chosen])) chosen = k;
    }
    lines.push_back(latex.substr(begin, points[chosen].position - begin));
    begin = points[chosen].position;
    before = points[chosen].width;
    next = std::min(chosen + 1, points.size() - 1);
  }
  return lines;
}

}  // namespace balance
