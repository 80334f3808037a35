#include "balance/dynamics/actuation.hpp"

#include <Eigen/SVD>

#include <algorithm>
#include <set>

namespace balance {

template <class S>
Actuation<S>::Actuation(const Mechanism& mechanism, const Tree<S>& tree, int freedoms)
    : columns_(tree.columns), closures_(tree.closure_rows), freedoms_(freedoms) {
  std::set<int> distinct;
  for (const int coordinate : mechanism.actuators) {
    const CoordinateSource& source = tree.sources[coordinate];
    actuated_.push_back({source.column, source.ratio});
    distinct.insert(source.column);
  }
  const int motors = static_cast<int>(actuated_.size());
  efforts_.assign(motors, 0);
  multipliers_.assign(closures_, 0);
  if (motors < freedoms)
    mismatch_ = "under-actuated: " + std::to_string(motors) + " actuators for " + std::to_string(freedoms) +
                " degrees of freedom; name as many coordinates in `actuators`";
  if (motors > freedoms)
    notes_.push_back("over-actuated: " + std::to_string(motors) + " actuators for " + std::to_string(freedoms) +
                     " degrees of freedom; the efforts are those of least norm");
  if (closures_ > columns_ - freedoms)
    notes_.push_back("the loops are over-constrained: reactions are those of least norm, not the only possible ones");
  const bool own_columns = static_cast<int>(distinct.size()) == motors;
  regular_ = motors == freedoms && own_columns && closures_ == columns_ - freedoms;
  if (regular_) prepare_regular(tree);
}

template <class S>
void Actuation<S>::prepare_regular(const Tree<S>& tree) {
  std::vector<int> position(columns_, -1);
  for (int c = 0; c < columns_; ++c) {
    const auto same = [c](const Selected& selected) { return selected.column == c; };
    if (std::any_of(actuated_.begin(), actuated_.end(), same)) continue;
    position[c] = static_cast<int>(passive_columns_.size());
    passive_columns_.push_back(c);
  }
  Eigen::MatrixXi pattern = Eigen::MatrixXi::Zero(closures_, columns_);
  int row = 0;
  for (const Closure<S>& closure : tree.closures)
    for (std::size_t r = 0; r < closure.rows.size(); ++r, ++row)
      for (const PathStep& step : closure.path) pattern(row, tree.nodes[step.node].column) = 1;
  Eigen::MatrixXi passive(closures_, closures_);
  for (int k = 0; k < closures_; ++k) passive.col(k) = pattern.col(passive_columns_[k]);
  if (!passive_.analyse(passive)) {
    regular_ = false;
    return;
  }
  for (int r = 0; r < closures_; ++r)
    for (int k = 0; k < closures_; ++k)
      if (passive(r, k)) gathered_.push_back({r, passive_columns_[k], passive_.index(r, k)});
  for (const Selected& motor : actuated_) {
    std::vector<int> rows;
    for (int r = 0; r < closures_; ++r)
      if (pattern(r, motor.column)) rows.push_back(r);
    rows_at_.push_back(rows);
  }
}

template <class S>
bool Actuation<S>::solve(const Equations<S>& equations, const double* tau) {
  return regular_ ? solve_regular(equations, tau) : solve_general(equations, tau);
}

template <class S>
bool Actuation<S>::solve_regular(const Equations<S>& equations, const double* tau) {
  for (std::size_t a = 0; a < actuated_.size(); ++a) efforts_[a] = tau[actuated_[a].column] / actuated_[a].ratio;
  if (closures_ == 0) return true;
  for (const Gathered& entry : gathered_) passive_.storage()[entry.index] = equations.entry(entry.row, entry.column);
  if (passive_.factorise() < 1e-10) return false;
  const std::vector<double>&columns = equations.column_scale(), &rows = equations.row_scale();
  for (int k = 0; k < closures_; ++k) multipliers_[k] = columns[passive_columns_[k]] * tau[passive_columns_[k]];
  passive_.solve_transposed(multipliers_.data());
  for (std::size_t a = 0; a < actuated_.size(); ++a) {
    double sum = 0;
    for (const int r : rows_at_[a]) sum += equations.entry(r, actuated_[a].column) * multipliers_[r];
    efforts_[a] -= sum / (columns[actuated_[a].column] * actuated_[a].ratio);
  }
  for (int r = 0; r < closures_; ++r) multipliers_[r] *= rows[r];
  return true;
}

template <class S>
bool Actuation<S>::solve_general(const Equations<S>& equations, const double* tau) {
  const std::vector<double>&columns = equations.column_scale(), &rows = equations.row_scale();
  const int motors = static_cast<int>(actuated_.size()), rank = columns_ - freedoms_;
  MatrixX closures(closures_, columns_);
  for (int r = 0; r < closures_; ++r)
    for (int c = 0; c < columns_; ++c) closures(r, c) = equations.entry(r, c);
  VectorX needed(columns_);
  for (int c = 0; c < columns_; ++c) needed[c] = columns[c] * tau[c];
  MatrixX selection = MatrixX::Zero(motors, columns_);
  for (int a = 0; a < motors; ++a)
    selection(a, actuated_[a].column) = actuated_[a].ratio * columns[actuated_[a].column];

  MatrixX null_space = MatrixX::Identity(columns_, columns_);
  Eigen::JacobiSVD<MatrixX> svd;
  if (closures_ > 0) {
    svd.compute(closures, Eigen::ComputeFullU | Eigen::ComputeFullV);
    null_space = svd.matrixV().rightCols(freedoms_);
  }
  const Eigen::JacobiSVD<MatrixX> grip(null_space.transpose() * selection.transpose(),
                                       Eigen::ComputeThinU | Eigen::ComputeThinV);
  const VectorX& strength = grip.singularValues();
  if (freedoms_ > 0 && (strength.size() < freedoms_ || strength[freedoms_ - 1] < 1e-10 * std::max(1e-300, strength[0])))
    return false;
  const VectorX efforts =
      freedoms_ > 0 ? VectorX(grip.solve(null_space.transpose() * needed)) : VectorX(VectorX::Zero(motors));
  for (int a = 0; a < motors; ++a) efforts_[a] = efforts[a];
  if (closures_ == 0) return true;
  // least-norm multipliers: only the kept singular directions
  const VectorX rest = svd.matrixV().leftCols(rank).transpose() * (needed - selection.transpose() * efforts);
  const VectorX multipliers = svd.matrixU().leftCols(rank) * rest.cwiseQuotient(svd.singularValues().head(rank));
  for (int r = 0; r < closures_; ++r) multipliers_[r] = rows[r] * multipliers[r];
  return true;
}

template class Actuation<Planar>;
template class Actuation<Spatial>;

}  // namespace balance
