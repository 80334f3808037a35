#include "balance/synthesis/certificate/figure_dual.hpp"

#include "balance/foundation/numerics/cone_program.hpp"
#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"

#include <Eigen/QR>
#include <Eigen/SVD>

#include <algorithm>
#include <cmath>

namespace balance::certificate {
namespace {

constexpr Eigen::Index parameters_per_element = 4;
/// Relative to the largest singular value: combinations of vanishing forces that vanish anyway.
constexpr double vanishing_rank_tolerance = 1e-10;
/// Penalty on what should vanish, relative to the figure; its growth while it does not; and what counts as vanished,
/// relative to the forces of the middle.
constexpr double first_penalty = 100, penalty_growth = 30, vanishing_tolerance = 1e-7;
constexpr int max_penalty_steps = 4;
constexpr double cone_tolerance = 1e-9;

/// The rows of a figure's series in the program.
struct SeriesRows {
  std::size_t figure = 0, series = 0;
  Eigen::Index first = 0;  ///< in the multipliers, of the linear or of the conic part
  bool is_linear = false;
  MatrixX basis;  ///< of rms: weights of the moments per row
};

class FigureDualSolver {
 public:
  FigureDualSolver(const FigureProblem& problem, const Mechanism& mechanism, const ForceRows& rows, const VectorX& x)
      : problem_(problem), mechanism_(mechanism), rows_(rows), x_(x) {
    list_unknowns();
  }

  std::optional<FigureDual> solve() {
    set_scales();
    double penalty = first_penalty;
    std::optional<FigureDual> best;
    for (int step = 0; step < max_penalty_steps; ++step, penalty *= penalty_growth) {
      std::optional<FigureDual> dual = solve_with(penalty);
      if (!dual) break;
      best = std::move(dual);
      if (reduced_vanishing_.rows() == 0 || residual_ <= vanishing_tolerance) break;
    }
    return best;
  }

 private:
  struct ElementUnknowns {
    int mass = -1, inertia = -1;
    std::array<int, 2> moments{-1, -1}, squares{-1, -1};
    double fixed_mass = 0;
    std::array<double, 2> place{};
    Eigen::Index column = 0;  ///< of its parameters
  };

  double lower(int number) const { return problem_.lower[number]; }
  double upper(int number) const { return problem_.upper[number]; }

  int add_unknown(double scale) {
    scales_.push_back(scale > 0 ? scale : 1);
    return static_cast<int>(scales_.size()) - 1;
  }

  void list_unknowns() {
    for (const FreeElement& element : problem_.elements) {
      ElementUnknowns unknowns;
      const std::size_t bodies = mechanism_.bodies.size() - 1;
      if (element.disc >= 0) {
        const auto disc = static_cast<std::size_t>(element.disc);
        unknowns.fixed_mass = mechanism_.discs[disc].mass;
        unknowns.column =
            parameters_per_element * static_cast<Eigen::Index>(bodies + mechanism_.attachments.size() + disc);
      } else {
        const auto index = static_cast<std::size_t>(element.attachment);
        const Attachment& attachment = mechanism_.attachments[index];
        unknowns.fixed_mass = attachment.mass;
        unknowns.place = {attachment.position[0], attachment.position[1]};
        unknowns.column = parameters_per_element * static_cast<Eigen::Index>(bodies + index);
      }
      double mass = unknowns.fixed_mass;
      if (element.mass_number >= 0) {
        mass = upper(element.mass_number);
        unknowns.mass = add_unknown(mass);
      }
      for (std::size_t k = 0; k < 2; ++k) {
        const int number = element.place_numbers[k];
        if (number < 0) continue;
        if (!(lower(number) < upper(number))) {
          unknowns.place[k] = lower(number);
          continue;
        }
        const double reach = std::max(std::abs(lower(number)), std::abs(upper(number)));
        unknowns.moments[k] = add_unknown(mass * reach);
        unknowns.squares[k] = add_unknown(mass * reach * reach);
      }
      if (element.inertia_number >= 0) unknowns.inertia = add_unknown(upper(element.inertia_number));
      elements_.push_back(unknowns);
    }
    unknowns_ = static_cast<Eigen::Index>(scales_.size());
  }

  /// Unit vector of an unknown, or the constant, times a factor.
  VectorX term(int unknown, double factor) const {
    VectorX row = VectorX::Zero(unknowns_ + 1);
    if (unknown >= 0)
      row[unknown] = factor * scales_[static_cast<std::size_t>(unknown)];
    else
      row[unknowns_] = factor;
    return row;
  }
  VectorX mass_row(const ElementUnknowns& element) const {
    return element.mass >= 0 ? term(element.mass, 1) : term(-1, element.fixed_mass);
  }

  /// parameters = map · (unknowns, 1).
  MatrixX parameter_map() const {
    MatrixX map = MatrixX::Zero(rows_.parameters.size() + 1, unknowns_ + 1);
    map.col(unknowns_).head(rows_.parameters.size()) = rows_.parameters;
    map(rows_.parameters.size(), unknowns_) = 1;
    for (std::size_t e = 0; e < elements_.size(); ++e) {
      const ElementUnknowns& element = elements_[e];
      const VectorX mass = mass_row(element);
      auto own = map.middleRows(element.column, parameters_per_element);
      own.setZero();
      own.row(0) = mass.transpose();
      if (element.inertia >= 0)
        own.row(3) = term(element.inertia, 1).transpose();
      else
        own(3, unknowns_) = fixed_inertia(problem_.elements[e]);
      for (std::size_t k = 0; k < 2; ++k) {
        const double place = element.place[k];
        const bool is_free = element.moments[k] >= 0;
        const VectorX moment = is_free ? term(element.moments[k], 1) : VectorX(place * mass);
        const VectorX square = is_free ? term(element.squares[k], 1) : VectorX(place * place * mass);
        own.row(1 + static_cast<Eigen::Index>(k)) = moment.transpose();
        own.row(3) += square.transpose();
      }
    }
    return map;
  }
  /// About the centre of mass.
  double fixed_inertia(const FreeElement& element) const {
    return element.disc >= 0 ? mechanism_.discs[static_cast<std::size_t>(element.disc)].inertia(2, 2)
                             : mechanism_.attachments[static_cast<std::size_t>(element.attachment)].inertia(2, 2);
  }

  /// Rows of a series, each moment times its scale.
  MatrixX scaled_rows(const ForceSeries& series, const MatrixX& map, bool is_peak) const {
    MatrixX rows = series.rows * map;
    if (!is_peak)
      for (Eigen::Index s = 0; s < series.time_weights.size(); ++s)
        rows.middleRows(s * series.components, series.components) *= std::sqrt(series.time_weights[s]);
    return rows;
  }

  void set_scales() {
    const MatrixX map = parameter_map();
    VectorX middle = VectorX::Constant(unknowns_ + 1, 0.25);
    middle[unknowns_] = 1;
    figure_scale_ = 0;
    for (std::size_t f = 0; f < problem_.figures.size(); ++f)
      for (const ForceSeries& series : rows_.figures[f]) {
        figures_.push_back(scaled_rows(series, map, problem_.figures[f].is_peak));
        const VectorX at = figures_.back() * middle;
        figure_scale_ = std::max(figure_scale_, problem_.figures[f].weight *
                                                    (problem_.figures[f].is_peak ? numerics::max_abs(at) : at.norm()));
      }
    if (!(figure_scale_ > 0)) figure_scale_ = 1;
    Eigen::Index count = 0;
    for (const auto& force : rows_.vanishing)
      for (const ForceSeries& series : force) count += series.rows.rows();
    if (count == 0) return;
    MatrixX vanishing(count, unknowns_ + 1);
    Eigen::Index first = 0;
    for (std::size_t f = 0; f < rows_.vanishing.size(); ++f)
      for (const ForceSeries& series : rows_.vanishing[f]) {
        vanishing.middleRows(first, series.rows.rows()) =
            scaled_rows(series, map, false) / vanishing_unit(problem_.vanishing[f]);
        first += series.rows.rows();
      }
    const double scale = (vanishing * middle).norm();
    if (scale > 0) vanishing /= scale;
    vanishing_scale_ = scale > 0 ? scale : 1;
    const numerics::SingularValueDecomposition svd(vanishing, Eigen::ComputeThinU | Eigen::ComputeThinV);
    const VectorX& values = svd.singularValues();
    Eigen::Index rank = 0;
    while (rank < values.size() && values[rank] > vanishing_rank_tolerance * values[0]) ++rank;
    vanishing_basis_ = svd.matrixU().leftCols(rank);
    reduced_vanishing_ = values.head(rank).asDiagonal() * svd.matrixV().leftCols(rank).transpose();
  }
  double vanishing_unit(const MotionForce& force) const {
    return force.kind == MotionForce::Kind::shaking_force ? 1 : characteristic_length(mechanism_);
  }

  /// Bounds on masses and places; moments of inertia between those of a point mass and of masses at both ends.
  void add_mass_constraints(numerics::ConeProgramBuilder& program) const {
    const auto add = [&](const VectorX& at_least_zero) {
      VectorX row = VectorX::Zero(variables_);
      row.head(unknowns_) = -at_least_zero.head(unknowns_);
      program.add_inequalities(row, at_least_zero[unknowns_]);
    };
    VectorX total = VectorX::Zero(unknowns_ + 1);
    for (std::size_t e = 0; e < elements_.size(); ++e) {
      const ElementUnknowns& element = elements_[e];
      const FreeElement& own = problem_.elements[e];
      const VectorX mass = mass_row(element);
      if (element.mass >= 0) {
        add(mass - term(-1, lower(own.mass_number)));
        add(term(-1, upper(own.mass_number)) - mass);
        if (own.is_added) total += mass;
      }
      if (element.inertia >= 0) {
        add(term(element.inertia, 1) - term(-1, lower(own.inertia_number)));
        add(term(-1, upper(own.inertia_number)) - term(element.inertia, 1));
      }
      for (std::size_t k = 0; k < 2; ++k) {
        if (element.moments[k] < 0) continue;
        const double low = lower(own.place_numbers[k]), high = upper(own.place_numbers[k]);
        const double reach = std::max(std::abs(low), std::abs(high));
        const VectorX moment = term(element.moments[k], 1), square = term(element.squares[k], 1);
        add(moment - low * mass);
        add(high * mass - moment);
        add((low + high) * moment - low * high * mass - square);
        // square · mass ≥ moment², in units of the largest place
        MatrixX rows = MatrixX::Zero(3, variables_);
        VectorX constant(3);
        const VectorX unit_square = square / (reach * reach), unit_moment = moment / reach;
        const std::array<VectorX, 3> parts{unit_square + mass, 2 * unit_moment, unit_square - mass};
        for (Eigen::Index r = 0; r < 3; ++r) {
          rows.row(r).head(unknowns_) = parts[static_cast<std::size_t>(r)].head(unknowns_).transpose();
          constant[r] = parts[static_cast<std::size_t>(r)][unknowns_];
        }
        const double scale = std::max(mass.cwiseAbs().sum(), 1e-12);
        program.add_cone(rows / scale, constant / scale);
      }
    }
    if (problem_.max_added_mass)
      add((term(-1, *problem_.max_added_mass) - total) / std::max(*problem_.max_added_mass, 1e-12));
  }

  std::optional<FigureDual> solve_with(double penalty) {
    const bool has_vanishing = reduced_vanishing_.rows() > 0;
    variables_ = unknowns_ + static_cast<Eigen::Index>(problem_.figures.size()) + (has_vanishing ? 1 : 0);
    numerics::ConeProgramBuilder program(variables_);
    add_mass_constraints(program);
    std::vector<SeriesRows> pieces;
    VectorX cost = VectorX::Zero(variables_);
    std::size_t block = 0;
    for (std::size_t f = 0; f < problem_.figures.size(); ++f) {
      const Eigen::Index epigraph = unknowns_ + static_cast<Eigen::Index>(f);
      cost[epigraph] = 1;  // of weighted figures
      const double scale = problem_.figures[f].weight / figure_scale_;
      for (std::size_t s = 0; s < rows_.figures[f].size(); ++s, ++block)
        add_series(f, s, scale * figures_[block], epigraph, program, pieces);
    }
    const Eigen::Index first_vanishing = program.conic_row_count();
    if (has_vanishing) {
      cost[variables_ - 1] = penalty;
      add_norm(reduced_vanishing_, variables_ - 1, program);
    }
    const numerics::ConeProgram built = program.build(cost);
    const numerics::ConeSolution solution = solve_cone_program(built, cone_tolerance);
    if (!solution.x.allFinite() || solution.x.size() == 0 || !solution.multipliers.allFinite()) return {};
    if (solution.status != numerics::ConeStatus::optimal && solution.iterations == 0) return {};
    FigureDual dual;
    dual.value = solution.x.tail(variables_ - unknowns_).dot(cost.tail(variables_ - unknowns_)) * figure_scale_;
    dual.figures.resize(problem_.figures.size());
    for (std::size_t f = 0; f < problem_.figures.size(); ++f) dual.figures[f].resize(rows_.figures[f].size());
    for (const SeriesRows& piece : pieces)
      dual.figures[piece.figure][piece.series] = read_multipliers(piece, built, solution);
    if (has_vanishing) {
      const VectorX reduced =
          -solution.multipliers.segment(built.linear_rows + first_vanishing + 1, reduced_vanishing_.rows());
      residual_ = solution.x[variables_ - 1];
      split_vanishing(vanishing_basis_ * reduced, dual);
    }
    dual.x = recover(solution.x);
    return dual;
  }

  void add_norm(const MatrixX& rows, Eigen::Index epigraph, numerics::ConeProgramBuilder& program) const {
    MatrixX cone = MatrixX::Zero(rows.rows() + 1, variables_);
    VectorX constant = VectorX::Zero(rows.rows() + 1);
    cone(0, epigraph) = 1;
    cone.block(1, 0, rows.rows(), unknowns_) = rows.leftCols(unknowns_);
    constant.tail(rows.rows()) = rows.col(unknowns_);
    program.add_cone(cone, constant);
  }

  void add_series(std::size_t figure, std::size_t series, const MatrixX& rows, Eigen::Index epigraph,
                  numerics::ConeProgramBuilder& program, std::vector<SeriesRows>& pieces) const {
    SeriesRows piece{figure, series, program.conic_row_count(), false, {}};
    const Eigen::Index components = rows_.figures[figure][series].components;
    if (!problem_.figures[figure].is_peak) {
      const Eigen::HouseholderQR<MatrixX> qr(rows);
      const Eigen::Index rank = std::min(rows.rows(), rows.cols());
      piece.basis = qr.householderQ() * MatrixX::Identity(rows.rows(), rank);
      const MatrixX triangle = qr.matrixQR().topRows(rank).triangularView<Eigen::Upper>();
      add_norm(triangle, epigraph, program);
    } else if (components == 1) {
      piece.first = program.linear_row_count();
      piece.is_linear = true;
      MatrixX both = MatrixX::Zero(2 * rows.rows(), variables_);
      both.topRows(rows.rows()).leftCols(unknowns_) = rows.leftCols(unknowns_);
      both.bottomRows(rows.rows()).leftCols(unknowns_) = -rows.leftCols(unknowns_);
      both.col(epigraph).setConstant(-1);
      VectorX limits(2 * rows.rows());
      limits << -rows.col(unknowns_), rows.col(unknowns_);
      program.add_inequalities(both, limits);
    } else {
      for (Eigen::Index first = 0; first < rows.rows(); first += components)
        add_norm(rows.middleRows(first, components), epigraph, program);
    }
    pieces.push_back(std::move(piece));
  }

  VectorX read_multipliers(const SeriesRows& piece, const numerics::ConeProgram& program,
                           const numerics::ConeSolution& solution) const {
    const ForceSeries& series = rows_.figures[piece.figure][piece.series];
    const Eigen::Index count = series.rows.rows();
    if (piece.is_linear)
      return solution.multipliers.segment(piece.first, count) -
             solution.multipliers.segment(piece.first + count, count);
    const Eigen::Index first = program.linear_rows + piece.first;
    if (piece.basis.cols() > 0) return -(piece.basis * solution.multipliers.segment(first + 1, piece.basis.cols()));
    VectorX weights(count);
    for (Eigen::Index s = 0; s < series.time_weights.size(); ++s)
      weights.segment(s * series.components, series.components) =
          -solution.multipliers.segment(first + s * (series.components + 1) + 1, series.components);
    return weights;
  }

  /// Multipliers of vanishing forces in the units of the figure.
  void split_vanishing(const VectorX& all, FigureDual& dual) const {
    Eigen::Index first = 0;
    for (std::size_t f = 0; f < rows_.vanishing.size(); ++f) {
      ForceMultipliers own;
      for (const ForceSeries& series : rows_.vanishing[f]) {
        own.push_back(all.segment(first, series.rows.rows()) * figure_scale_ /
                      (vanishing_scale_ * vanishing_unit(problem_.vanishing[f])));
        first += series.rows.rows();
      }
      dual.vanishing.push_back(std::move(own));
    }
  }

  VectorX recover(const VectorX& solution) const {
    VectorX x = x_;
    const auto value = [&](int unknown) { return solution[unknown] * scales_[static_cast<std::size_t>(unknown)]; };
    const auto set = [&](int number, double to) { x[number] = std::clamp(to, lower(number), upper(number)); };
    for (std::size_t e = 0; e < elements_.size(); ++e) {
      const ElementUnknowns& element = elements_[e];
      const FreeElement& own = problem_.elements[e];
      const double mass = element.mass >= 0 ? value(element.mass) : element.fixed_mass;
      if (element.mass >= 0) set(own.mass_number, mass);
      if (element.inertia >= 0) set(own.inertia_number, value(element.inertia));
      for (std::size_t k = 0; k < 2; ++k)
        if (element.moments[k] >= 0 && mass > 0) set(own.place_numbers[k], value(element.moments[k]) / mass);
    }
    return x;
  }

  const FigureProblem& problem_;
  const Mechanism& mechanism_;
  const ForceRows& rows_;
  const VectorX& x_;
  std::vector<ElementUnknowns> elements_;
  std::vector<double> scales_;  ///< of the unknowns
  Eigen::Index unknowns_ = 0, variables_ = 0;
  std::vector<MatrixX> figures_;  ///< per figure and series
  double figure_scale_ = 1, vanishing_scale_ = 1, residual_ = 0;
  MatrixX vanishing_basis_, reduced_vanishing_;
};

}  // namespace

std::optional<FigureDual> solve_figure_dual(const FigureProblem& problem, const Mechanism& mechanism,
                                            const ForceRows& rows, const VectorX& x) {
  return FigureDualSolver(problem, mechanism, rows, x).solve();
}

}  // namespace balance::certificate
