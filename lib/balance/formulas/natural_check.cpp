#include "balance/formulas/natural_check.hpp"

#include "balance/base/elementary.hpp"
#include "balance/base/extrema.hpp"
#include "balance/formulas/text_value.hpp"
#include "balance/natural/terms.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace balance::formulas {

namespace {

class NaturalComparison {
 public:
  NaturalComparison(const FormulaSheet& sheet, const std::map<std::string, std::string>& texts,
                    natural::NaturalTerms expected, std::map<std::string, double> names)
      : natural_(*sheet.natural),
        texts_(texts),
        ring_(*sheet.ring),
        expected_(std::move(expected)),
        names_(std::move(names)) {
    for (std::size_t u = 0; u < natural_.unknowns.size(); ++u)
      unknown(u) = expected_.position(static_cast<Eigen::Index>(u / 2), static_cast<Eigen::Index>(u % 2));
  }

  double error() { return std::max({mass_error(), coefficient_error(), constraint_error(), jacobian_error()}); }

 private:
  double& unknown(std::size_t u) { return names_[ring_.symbol(natural_.unknowns[u]).name]; }

  double value(const std::string& label, const Polynomial& p) const {
    if (p.is_zero()) return 0;
    if (const auto text = texts_.find(label); text != texts_.end()) return evaluate_text(text->second, names_);
    std::vector<double> symbols, angles;
    for (const Symbol& symbol : ring_.symbols()) symbols.push_back(names_.at(symbol.name));
    for (const Angle& angle : ring_.angles()) angles.push_back(names_.at(angle.name));
    return evaluate_polynomial(p, symbols, angles);
  }

  double mass_error() const {
    const std::size_t p = natural_.points.size();
    double worst = 0;
    for (std::size_t i = 0; i < p; ++i)
      for (std::size_t j = i; j < p; ++j) {
        const auto row = static_cast<Eigen::Index>(2 * i), column = static_cast<Eigen::Index>(2 * j);
        const std::string indices = index_text({i, j}, p);
        worst = std::max({worst, std::abs(value("Mre" + indices, natural_.mass[i][j].re) - expected_.mass(row, column)),
                          std::abs(value("Mim" + indices, natural_.mass[i][j].im) - expected_.mass(row + 1, column))});
      }
    return worst / std::max(max_abs(expected_.mass), 1e-300);
  }

  double coefficient_error() const {
    const std::size_t p = natural_.points.size();
    double worst = 0, scale = 1e-300;
    for (std::size_t i = 0; i < p; ++i) {
      const std::complex<double> C = expected_.coefficients[i].coefficient;
      const std::string indices = index_text({i}, p);
      worst = std::max(worst, std::abs(std::complex<double>(value("Cre" + indices, natural_.coefficients[i].re),
                                                            value("Cim" + indices, natural_.coefficients[i].im)) -
                                       C));
      scale = std::max(scale, std::abs(C));
    }
    return worst / scale;
  }

  double constraint(std::size_t r) const {
    const std::size_t count = std::max(natural_.constraint.size(), natural_.unknowns.size());
    return value("Phi" + index_text({r}, count), natural_.constraint[r]);
  }

  double constraint_error() const {
    double worst = 0;
    for (std::size_t r = 0; r < natural_.constraint.size(); ++r) worst = std::max(worst, std::abs(constraint(r)));
    return worst / elementary::pow(expected_.unit + max_coordinate(), 2);
  }

  /// Farthest point from the origin [m].
  double max_coordinate() const { return max_abs(expected_.position); }

  double jacobian_error() {
    const double step = expected_.unit + max_coordinate();
    const std::size_t count = std::max(natural_.constraint.size(), natural_.unknowns.size());
    double worst = 0, scale = 1e-300;
    for (std::size_t u = 0; u < natural_.unknowns.size(); ++u)
      for (std::size_t r = 0; r < natural_.constraint.size(); ++r) {
        const double printed = value("G" + index_text({r, u}, count), natural_.jacobian[r][u]), here = unknown(u);
        unknown(u) = here + step;
        const double above = constraint(r);
        unknown(u) = here - step;
        const double below = constraint(r);
        unknown(u) = here;
        worst = std::max(worst, std::abs((above - below) / (2 * step) - printed));
        scale = std::max({scale, std::abs(printed), (std::abs(above) + std::abs(below)) / step});
      }
    return worst / scale;
  }

  const NaturalEquations& natural_;
  const std::map<std::string, std::string>& texts_;
  const Ring& ring_;
  natural::NaturalTerms expected_;
  std::map<std::string, double> names_;
};

}  // namespace

double max_natural_error(const FormulaSheet& sheet, const std::map<std::string, std::string>& texts,
                         const Mechanism& mechanism, std::map<std::string, double> names, const VectorX& coordinates) {
  natural::NaturalTerms expected = natural::compute_natural_terms(mechanism, coordinates);
  if (expected.points != sheet.natural->points) return std::numeric_limits<double>::quiet_NaN();
  return NaturalComparison(sheet, texts, std::move(expected), std::move(names)).error();
}

}  // namespace balance::formulas
