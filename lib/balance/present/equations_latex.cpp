#include "balance/base/extrema.hpp"
#include "balance/conditions/latex.hpp"
#include "balance/present/equations_view.hpp"

#include <fmt/format.h>

#include <cmath>

namespace balance {

namespace {

constexpr double latex_zero_tolerance = 1e-13;   ///< of the largest entry: printed as 0
constexpr Eigen::Index max_matrix_columns = 10;  ///< that amsmath's matrices take without being asked

std::string number_latex(double value, double size) {
  if (std::abs(value) <= latex_zero_tolerance * size) return "0";
  std::string text = fmt::format("{:.6g}", value);
  if (const std::size_t e = text.find('e'); e != std::string::npos)
    text = fmt::format("{} \\cdot 10^{{{}}}", text.substr(0, e), std::stoi(text.substr(e + 1)));
  return text;
}

std::string matrix_latex(const MatrixX& matrix) {
  const double size = max_abs(matrix);
  std::string text = "\\begin{pmatrix}";
  for (Eigen::Index r = 0; r < matrix.rows(); ++r) {
    text += r == 0 ? " " : " \\\\ ";
    for (Eigen::Index c = 0; c < matrix.cols(); ++c) text += (c == 0 ? "" : " & ") + number_latex(matrix(r, c), size);
  }
  return text + " \\end{pmatrix}";
}

class AlignedLines {
 public:
  void add(const std::string& name, const std::string& value) {
    text_ += (text_.empty() ? "  " : " \\\\\n  ") + name + " &= " + value;
  }
  std::string all(Eigen::Index widest) const {
    const std::string wide =
        widest > max_matrix_columns ? fmt::format("\\setcounter{{MaxMatrixCols}}{{{}}}\n", widest) : std::string();
    return wide + "\\begin{align*}\n" + text_ + "\n\\end{align*}\n";
  }

 private:
  std::string text_;
};

}  // namespace

std::string equations_latex(const EquationsReportData& view) {
  using enum EquationSection;
  const EquationsAtConfiguration& at = view.at;
  AlignedLines lines;
  Eigen::Index widest = at.terms->mass.cols();
  std::string names;
  for (const std::string& name : at.independent) names += (names.empty() ? "" : ",\\, ") + symbol_latex(name);
  lines.add("q", "\\left(" + names + "\\right)^{\\mathsf T}");
  if (view.shows(inertia)) lines.add("M'", matrix_latex(at.terms->mass));
  if (view.shows(velocity))
    for (std::size_t k = 0; k < at.independent.size(); ++k)
      lines.add(fmt::format("D'_{{{}}}", k + 1), matrix_latex(at.terms->velocity[k]));
  if (view.shows(velocity)) lines.add("B'", matrix_latex(at.terms->viscous));
  if (view.shows(gravity)) lines.add("z'", matrix_latex(at.terms->static_terms.sum()));
  if (at.diagonal_factors && view.shows(inertia)) lines.add("k", matrix_latex(*at.diagonal_factors));
  if (at.split && view.shows(torques)) lines.add("u", matrix_latex(at.split->effort));
  if (at.loops && view.shows(redundant)) {
    lines.add("M", matrix_latex(at.loops->mass));
    lines.add("C", matrix_latex(at.loops->transformation));
    if (at.loops->constraints.rows() > 0) lines.add("A", matrix_latex(at.loops->constraints));
    lines.add("z", matrix_latex(at.loops->rest.sum()));
    widest = std::max(widest, at.loops->mass.cols());
  }
  if (at.natural) {
    lines.add("M_{\\text{points}}", matrix_latex(at.natural->mass));
    widest = std::max(widest, at.natural->mass.cols());
    for (const natural::PointMatrix& one : at.natural->coefficients) {
      const double re = one.coefficient.real(), im = one.coefficient.imag();
      lines.add("C_{" + symbol_latex(one.point) + "}", matrix_latex((Eigen::Matrix2d() << re, -im, im, re).finished()));
    }
  }
  if (at.parameters)
    for (int row = 0; row < at.parameters->rank; ++row) {
      std::string text = condition_latex(*at.parameters, row, at.parameter_names);
      lines.add(fmt::format("\\pi_{{{}}}", row + 1), text.substr(0, text.rfind(" = ")));
    }
  return lines.all(widest);
}

}  // namespace balance
