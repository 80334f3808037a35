#include "balance/synthesis/certificate/motion_enclosure.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/mechanics/kinematics/closure.hpp"

#include <Eigen/LU>

#include <algorithm>

namespace balance::certificate {
namespace {

using kinematics::Closure;
using kinematics::PathStep;

/// Krawczyk's operator: first radius relative to the first correction, its growth where the test fails, absolute
/// allowance, and limits [rad or m].
constexpr double first_radius_factor = 1.2, radius_growth = 1.3, min_krawczyk_radius = 1e-13, max_krawczyk_radius = 0.7;
constexpr int max_krawczyk_steps = 8, tightening_steps = 2;

Interval product(const MatrixX& matrix, std::size_t row, const IntervalVector& x) {
  Interval sum;
  for (std::size_t k = 0; k < x.size(); ++k)
    sum += x[k] * matrix(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(k));
  return sum;
}

Interval symmetric_interval(double radius) { return {-radius, radius}; }

}  // namespace

MatrixX invert_middle(const JetMatrix& matrix) {
  const auto n = static_cast<Eigen::Index>(matrix.size);
  MatrixX middle(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j)
      middle(i, j) = matrix.at(static_cast<std::size_t>(i), static_cast<std::size_t>(j)).value.middle();
  if (n == 0) return middle;
  MatrixX result = Eigen::PartialPivLU<MatrixX>(middle).inverse();
  if (!result.allFinite() || !(result.cwiseAbs().sum() < max_interval_magnitude))
    throw EnclosureError("the motion is singular");
  return result;
}

void IntervalSolver::set(const MatrixX& approximate_inverse, const JetMatrix& matrix) {
  inverse_ = approximate_inverse;
  const std::size_t n = matrix.size;
  factors_.assign(n * n, Interval());
  IntervalVector column(n);
  for (std::size_t j = 0; j < n; ++j) {
    for (std::size_t i = 0; i < n; ++i) column[i] = matrix.at(i, j).value;
    for (std::size_t i = 0; i < n; ++i) factors_[i * n + j] = product(inverse_, i, column);
  }
  for (std::size_t k = 0; k < n; ++k) {
    const Interval pivot = inverse(factors_[k * n + k]);
    for (std::size_t i = k + 1; i < n; ++i) {
      const Interval factor = factors_[i * n + k] * pivot;
      factors_[i * n + k] = factor;
      for (std::size_t j = k + 1; j < n; ++j) factors_[i * n + j] -= factor * factors_[k * n + j];
    }
  }
}

IntervalVector IntervalSolver::solve(const IntervalVector& right) const {
  const std::size_t n = right.size();
  IntervalVector x(n);
  for (std::size_t i = 0; i < n; ++i) x[i] = product(inverse_, i, right);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t k = 0; k < i; ++k) x[i] -= factors_[i * n + k] * x[k];
  for (std::size_t i = n; i-- > 0;) {
    for (std::size_t k = i + 1; k < n; ++k) x[i] -= factors_[i * n + k] * x[k];
    x[i] = x[i] / factors_[i * n + i];
  }
  return x;
}

std::vector<IntervalJet> IntervalSolver::solve(const JetMatrix& matrix, const std::vector<IntervalJet>& right,
                                               int variables, int order) const {
  const std::size_t n = right.size();
  IntervalVector b(n);
  for (std::size_t r = 0; r < n; ++r) b[r] = right[r].value;
  const IntervalVector value = solve(b);
  std::vector<IntervalJet> x(n);
  for (std::size_t c = 0; c < n; ++c) {
    x[c].set_variables(variables, order);
    x[c].value = value[c];
  }
  if (order < 1) return x;
  for (int i = 0; i < variables; ++i) {  // J x_i = b_i − J_i x
    for (std::size_t r = 0; r < n; ++r) {
      b[r] = right[r].derivative(i);
      for (std::size_t c = 0; c < n; ++c)
        if (!matrix.at(r, c).is_constant()) b[r] -= matrix.at(r, c).derivative(i) * value[c];
    }
    const IntervalVector slope = solve(b);
    for (std::size_t c = 0; c < n; ++c) x[c].gradient(i) = slope[c];
  }
  if (order < 2) return x;
  for (int j = 0; j < variables; ++j)
    for (int i = 0; i <= j; ++i) {  // J x_ij = b_ij − J_ij x − J_i x_j − J_j x_i
      for (std::size_t r = 0; r < n; ++r) {
        b[r] = right[r].second_derivative(i, j);
        for (std::size_t c = 0; c < n; ++c) {
          const IntervalJet& entry = matrix.at(r, c);
          if (entry.is_constant()) continue;
          b[r] -= entry.second_derivative(i, j) * value[c] + entry.derivative(i) * x[c].gradient(j) +
                  entry.derivative(j) * x[c].gradient(i);
        }
      }
      const IntervalVector curvature = solve(b);
      for (std::size_t c = 0; c < n; ++c) x[c].hessian(i, j) = curvature[c];
    }
  return x;
}

MotionEnclosure::MotionEnclosure(const BoxLinkages& linkages, PlanarDrive drive)
    : linkages_(linkages),
      drive_(std::move(drive)),
      variables_(static_cast<int>(linkages.steps.size())),
      columns_(static_cast<std::size_t>(linkages.last.tree.columns)),
      state_(linkages.last.tree.nodes.size()) {}

bool MotionEnclosure::enclose(const MotionPoint& at) {
  const std::size_t rows = static_cast<std::size_t>(linkages_.last.tree.closure_rows) + drive_.size();
  if (rows != columns_ || at.y.size() != static_cast<Eigen::Index>(columns_)) return false;
  try {
    enclose_coordinates(at);
    differentiate_coordinates(at);
    enclose_rates(at);
  } catch (const EnclosureError&) {
    return false;
  }
  return true;
}

/// y₀ − C f(y₀, L) + (1 − C J(Y, L)) (Y − y₀) inside Y shows that there is one solution in Y for each l of L. With the
/// mean value theorem, f(y₀, L) = f(y₀, middle) + f_l(y₀, L) (L − middle).
void MotionEnclosure::enclose_coordinates(const MotionPoint& at) {
  std::vector<IntervalJet> y(columns_);
  for (std::size_t c = 0; c < columns_; ++c) y[c] = at.y[static_cast<Eigen::Index>(c)];
  evaluate(linkages_.middle, y, at, true);
  inverse_ = invert_middle(matrix_);
  IntervalVector f(columns_), correction(columns_);
  for (std::size_t r = 0; r < columns_; ++r) f[r] = residual_[r].value;
  for (std::size_t c = 0; c < columns_; ++c) correction[c] = -product(inverse_, c, f);
  evaluate(linkages_.slopes, y, at, false);
  for (int i = 0; i < variables_; ++i) {
    for (std::size_t r = 0; r < columns_; ++r) f[r] = residual_[r].derivative(i);
    for (std::size_t c = 0; c < columns_; ++c)
      correction[c] -= product(inverse_, c, f) * linkages_.steps[static_cast<std::size_t>(i)];
  }
  std::vector<double> radius(columns_);
  for (std::size_t c = 0; c < columns_; ++c)
    radius[c] = first_radius_factor * correction[c].magnitude() + min_krawczyk_radius * (1 + y[c].value.magnitude());
  const std::vector<IntervalJet> start = y;
  IntervalVector image(columns_), column(columns_), deviation(columns_);
  for (std::size_t c = 0; c < columns_; ++c) deviation[c] = symmetric_interval(radius[c]);
  bool is_shown = false;
  for (int step = 0, tightened = 0; step < max_krawczyk_steps && tightened < tightening_steps; ++step) {
    for (std::size_t c = 0; c < columns_; ++c) y[c] = start[c].value + deviation[c];
    evaluate(linkages_.values, y, at, true);
    image = correction;
    for (std::size_t k = 0; k < columns_; ++k) {
      for (std::size_t r = 0; r < columns_; ++r) column[r] = matrix_.at(r, k).value;
      for (std::size_t c = 0; c < columns_; ++c)
        image[c] += ((c == k ? 1.0 : 0.0) - product(inverse_, c, column)) * deviation[k];
    }
    if (is_shown) {  // the solutions are in both
      for (std::size_t c = 0; c < columns_; ++c) deviation[c] = intersect(deviation[c], image[c]);
      ++tightened;
      continue;
    }
    is_shown = true;
    for (std::size_t c = 0; c < columns_; ++c) is_shown = is_shown && image[c].is_inside(deviation[c]);
    for (std::size_t c = 0; c < columns_; ++c) {
      if (is_shown) {
        deviation[c] = image[c];
        continue;
      }
      radius[c] = std::max(radius[c], radius_growth * image[c].magnitude());
      if (!(radius[c] < max_krawczyk_radius)) throw EnclosureError("no unique configuration was shown");
      deviation[c] = symmetric_interval(radius[c]);
    }
  }
  if (!is_shown) throw EnclosureError("no unique configuration was shown");
  y_.assign(columns_, IntervalJet());
  for (std::size_t c = 0; c < columns_; ++c) {
    y_[c].set_variables(variables_, linkages_.order);
    y_[c].value = start[c].value + deviation[c];
  }
}

/// f(y(l), l) = 0 is differentiated. With y_l = 0 the gradient of f is f_l = −J y_l; with the right y_l and y_ll = 0 its
/// second derivative is −J y_ll.
void MotionEnclosure::differentiate_coordinates(const MotionPoint& at) {
  const int order = linkages_.order;
  std::vector<IntervalJet> y(columns_);
  for (std::size_t c = 0; c < columns_; ++c) {
    y[c].set_variables(variables_, 1);
    y[c].value = y_[c].value;
  }
  evaluate(linkages_.slopes, y, at, true);
  solver_.set(inverse_, matrix_);
  IntervalVector right(columns_);
  for (int i = 0; i < variables_; ++i) {
    for (std::size_t r = 0; r < columns_; ++r) right[r] = -residual_[r].derivative(i);
    const IntervalVector slope = solver_.solve(right);
    for (std::size_t c = 0; c < columns_; ++c) y_[c].gradient(i) = slope[c];
  }
  if (order > 1) {
    evaluate(linkages_.last, y_, at, false);
    std::vector<IntervalVector> curvatures;
    for (int j = 0; j < variables_; ++j)
      for (int i = 0; i <= j; ++i) {
        for (std::size_t r = 0; r < columns_; ++r) right[r] = -residual_[r].second_derivative(i, j);
        curvatures.push_back(solver_.solve(right));
      }
    std::size_t k = 0;
    for (int j = 0; j < variables_; ++j)
      for (int i = 0; i <= j; ++i, ++k)
        for (std::size_t c = 0; c < columns_; ++c) y_[c].hessian(i, j) = curvatures[k][c];
  }
}

void MotionEnclosure::enclose_rates(const MotionPoint& at) {
  const kinematics::Tree<IntervalPlane>& tree = linkages_.last.tree;
  evaluate(linkages_.last, y_, at, true);
  solver_.set(inverse_, matrix_);
  std::vector<IntervalJet> right(columns_, IntervalJet());
  const auto first = static_cast<std::size_t>(tree.closure_rows);
  for (std::size_t k = 0; k < drive_.size(); ++k) right[first + k] = at.rate[static_cast<Eigen::Index>(k)];
  dy_ = solver_.solve(matrix_, right, variables_, linkages_.order);
  kinematics::compute_velocities<IntervalPlane>(tree, dy_.data(), state_);
  const IntervalPlane::Vector still(IntervalJet(0.0), IntervalJet(0.0));
  kinematics::compute_accelerations<IntervalPlane>(tree, dy_.data(), nullptr, still, state_);
  std::size_t row = 0;
  for (const Closure<IntervalPlane>& closure : tree.closures) {
    kinematics::closure_bias<IntervalPlane>(state_, closure, kinematics::closure_pose<IntervalPlane>(state_, closure),
                                            right.data() + row);
    for (std::size_t r = 0; r < closure.rows.size(); ++r, ++row) right[row] = -right[row];
  }
  for (std::size_t k = 0; k < drive_.size(); ++k) right[row + k] = at.acceleration[static_cast<Eigen::Index>(k)];
  if (!drive_.point.empty()) {
    const kinematics::FixedFrame<IntervalPlane>& tool = linkages_.last.tool;
    const IntervalPlane::Vector bias = kinematics::point_acceleration<IntervalPlane>(state_[tool.node], tool.p_N);
    for (std::size_t k = 0; k < drive_.point.size(); ++k) right[row + k] -= bias[drive_.point[k]];
  }
  ddy_ = solver_.solve(matrix_, right, variables_, linkages_.order);
  kinematics::compute_accelerations<IntervalPlane>(tree, dy_.data(), ddy_.data(), still, state_);
}

std::vector<IntervalJet> MotionEnclosure::solve_rates(const std::vector<CoordinateId>& driven,
                                                      const std::vector<IntervalJet>& rates) {
  const kinematics::Tree<IntervalPlane>& tree = linkages_.last.tree;
  const auto first = static_cast<std::size_t>(tree.closure_rows);
  std::vector<IntervalJet> right(columns_, IntervalJet());
  for (std::size_t k = 0; k < rates.size(); ++k) right[first + k] = rates[k];
  if (drive_.point.empty() && driven == drive_.coordinates)
    return solver_.solve(matrix_, right, variables_, linkages_.order);
  if (first + driven.size() != columns_) throw EnclosureError("the actuators do not determine the motion");
  JetMatrix matrix = matrix_;
  for (std::size_t k = 0; k < driven.size(); ++k) {
    for (std::size_t c = 0; c < columns_; ++c) matrix.at(first + k, c) = 0.0;
    for (const auto& [column, ratio] : tree.coordinate_expressions[static_cast<std::size_t>(driven[k])].terms)
      matrix.at(first + k, static_cast<std::size_t>(column)) += ratio;
  }
  IntervalSolver solver;
  solver.set(invert_middle(matrix), matrix);
  return solver.solve(matrix, right, variables_, linkages_.order);
}

void MotionEnclosure::evaluate(const LinkageEnclosure& linkage, const std::vector<IntervalJet>& y,
                               const MotionPoint& at, bool has_matrix) {
  kinematics::compute_poses<IntervalPlane>(linkage.tree, y.data(), state_);
  residual_.assign(columns_, IntervalJet());
  if (has_matrix) matrix_.reset(columns_);
  std::size_t row = 0;
  for (const Closure<IntervalPlane>& closure : linkage.tree.closures) {
    evaluate_closure(linkage, closure, row, has_matrix);
    row += closure.rows.size();
  }
  evaluate_drive(linkage, y, at, row, has_matrix);
}

void MotionEnclosure::evaluate_closure(const LinkageEnclosure& linkage, const Closure<IntervalPlane>& closure,
                                       std::size_t row, bool has_matrix) {
  const auto pose = kinematics::closure_pose<IntervalPlane>(state_, closure);
  const std::size_t rows = closure.rows.size();
  if (kinematics::is_point_closure(closure)) {
    for (int i = 0; i < 2; ++i) residual_[row + static_cast<std::size_t>(i)] = pose.p_B[i] - pose.p_A[i];
    if (!has_matrix) return;
    for (const PathStep& step : closure.path) {
      const kinematics::Node<IntervalPlane>& node = linkage.tree.nodes[static_cast<std::size_t>(step.node)];
      const IntervalPlane::Vector v =
          kinematics::partial_velocity<IntervalPlane>(node, state_[static_cast<std::size_t>(step.node)], pose.p_B);
      for (int i = 0; i < 2; ++i)
        matrix_.at(row + static_cast<std::size_t>(i), static_cast<std::size_t>(node.column)) += v[i] * step.sign;
    }
    return;
  }
  for (std::size_t r = 0; r < rows; ++r) {
    residual_[row + r] = kinematics::closure_residual(pose, closure.rows[r]);
    if (!has_matrix) continue;
    const auto wrench = kinematics::closure_wrench<IntervalPlane>(closure, pose, closure.rows[r]);
    for (const PathStep& step : closure.path) {
      const kinematics::Node<IntervalPlane>& node = linkage.tree.nodes[static_cast<std::size_t>(step.node)];
      matrix_.at(row + r, static_cast<std::size_t>(node.column)) +=
          kinematics::wrench_power<IntervalPlane>(node, state_[static_cast<std::size_t>(step.node)], pose.p_B, wrench) *
          step.sign;
    }
  }
}

void MotionEnclosure::evaluate_drive(const LinkageEnclosure& linkage, const std::vector<IntervalJet>& y,
                                     const MotionPoint& at, std::size_t row, bool has_matrix) {
  Eigen::Index k = 0;
  if (!drive_.point.empty()) {
    const IntervalPlane::Vector place = kinematics::position<IntervalPlane>(state_, linkage.tool);
    for (const int component : drive_.point)
      residual_[row + static_cast<std::size_t>(k)] = place[component] - IntervalJet(at.value[k]), ++k;
    for (int n = linkage.tool.node; has_matrix && n > 0; n = linkage.tree.nodes[static_cast<std::size_t>(n)].parent) {
      const kinematics::Node<IntervalPlane>& node = linkage.tree.nodes[static_cast<std::size_t>(n)];
      if (node.motion == kinematics::NodeMotion::weld) continue;
      const IntervalPlane::Vector v =
          kinematics::partial_velocity<IntervalPlane>(node, state_[static_cast<std::size_t>(n)], place);
      for (std::size_t p = 0; p < drive_.point.size(); ++p)
        matrix_.at(row + p, static_cast<std::size_t>(node.column)) += v[drive_.point[p]];
    }
  }
  for (const CoordinateId coordinate : drive_.coordinates) {
    const auto& quantity = linkage.tree.coordinate_expressions[static_cast<std::size_t>(coordinate)];
    const std::size_t own = row + static_cast<std::size_t>(k);
    residual_[own] = quantity.value(y.data()) - IntervalJet(at.value[k++]);
    if (!has_matrix) continue;
    for (const auto& [column, ratio] : quantity.terms) matrix_.at(own, static_cast<std::size_t>(column)) += ratio;
  }
}

}  // namespace balance::certificate
