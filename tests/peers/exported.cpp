/// Runs an exported MJCF in MuJoCo along the motion of a run of its spec and compares the efforts.
///
/// Without equality constraints `mj_inverse` has the efforts. With them, MuJoCo's own inverse holds soft constraints,
/// whose forces depend on their stiffness, and so it does dry friction, which is added here. The forces of the tree
/// (`mj_inverse` with constraints disabled) and the constraints' Jacobian J (`efc_J`) are exact: τ = Sᵀ u + Jᵀ λ is solved for the efforts u and λ.
///
/// usage: compare_exported MJCF RESULT

#include "balance/foundation/base/types.hpp"
#include "balance/interface/files/result_file.hpp"

#include <fmt/format.h>
#include <mujoco/mujoco.h>
#include <Eigen/QR>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace balance::peers {
namespace {

/// Of the largest effort. Both are exact; balance closes loops to 1e-12 of the mechanism's size.
constexpr double effort_tolerance = 1e-6;
/// Of a length of 1 m or an angle: how far equality constraints are from closed at the run's coordinates.
constexpr double closure_tolerance = 1e-8;

struct Deleter {
  void operator()(mjModel* model) const { mj_deleteModel(model); }
  void operator()(mjData* data) const { mj_deleteData(data); }
};

/// Positions, rates and accelerations of one state.
struct State {
  VectorX q, dq, ddq;
};

class ExportedModel {
 public:
  explicit ExportedModel(const std::string& path) {
    char message[1000] = "";
    model_.reset(mj_loadXML(path.c_str(), nullptr, message, sizeof message));
    if (!model_) throw std::runtime_error(message);
    if (model_->nq != model_->nv) throw std::runtime_error("a joint has several coordinates");
    data_.reset(mj_makeData(model_.get()));
    for (int a = 0; a < model_->nu; ++a) motors_.push_back(model_->actuator_trnid[2 * a]);
  }

  int size() const { return model_->nv; }
  std::string joint_name(int j) const { return mj_id2name(model_.get(), mjOBJ_JOINT, j); }
  const std::vector<int>& motors() const { return motors_; }

  /// Coordinates that the run does not have are those of discs: they follow from the equality constraints.
  void complete(const std::vector<bool>& is_known, State& state) const {
    const auto count = static_cast<Eigen::Index>(std::count(is_known.begin(), is_known.end(), false));
    if (count == 0) return;
    std::vector<int> unknown;
    for (int j = 0; j < size(); ++j)
      if (!is_known[static_cast<std::size_t>(j)]) unknown.push_back(j);
    MatrixX rows = MatrixX::Zero(model_->neq, size());
    VectorX offset = VectorX::Zero(model_->neq);
    for (int e = 0; e < model_->neq; ++e) add_linear_row(e, rows.row(e), offset[e]);
    const MatrixX columns = rows(Eigen::all, unknown);
    const Eigen::CompleteOrthogonalDecomposition<MatrixX> solver(columns);
    for (auto [values, constant] :
         {std::pair(&state.q, true), std::pair(&state.dq, false), std::pair(&state.ddq, false)}) {
      for (const int j : unknown) (*values)[j] = 0;
      const VectorX right = -(rows * *values) - (constant ? offset : VectorX(VectorX::Zero(model_->neq)));
      // rows of closures, and of couplings of known coordinates, are zero in these columns
      const VectorX found = solver.solve(right);
      for (std::size_t k = 0; k < unknown.size(); ++k) (*values)[unknown[k]] = found[static_cast<Eigen::Index>(k)];
    }
  }

  /// Efforts of the motors. @param closure largest violation of an equality constraint
  VectorX compute_efforts(const State& state, double& closure, double& residual) {
    mjModel& model = *model_;
    mjData& data = *data_;
    VectorX::Map(data.qpos, size()) = state.q;
    VectorX::Map(data.qvel, size()) = state.dq;
    VectorX::Map(data.qacc, size()) = state.ddq;
    const int flags = model.opt.disableflags;
    MatrixX jacobian(0, size());
    closure = residual = 0;
    if (model.neq > 0) {
      mj_fwdPosition(&model, &data);
      jacobian.resize(data.ne, size());
      for (int r = 0; r < data.ne; ++r) {
        if (mj_isSparse(&model))
          set_sparse_row(r, jacobian.row(r));
        else
          jacobian.row(r) = Eigen::RowVectorXd::Map(data.efc_J + static_cast<std::ptrdiff_t>(r) * size(), size());
        closure = std::max(closure, std::abs(data.efc_pos[r]));
      }
    }
    model.opt.disableflags |= mjDSBL_CONSTRAINT;
    mj_inverse(&model, &data);
    model.opt.disableflags = flags;
    VectorX forces = VectorX::Map(data.qfrc_inverse, size());
    forces += VectorX::Map(model.dof_frictionloss, size()).cwiseProduct(state.dq.cwiseSign());
    if (model.neq == 0) {
      VectorX efforts(static_cast<Eigen::Index>(motors_.size()));
      for (std::size_t a = 0; a < motors_.size(); ++a) efforts[static_cast<Eigen::Index>(a)] = forces[motors_[a]];
      return efforts;
    }
    MatrixX matrix(size(), static_cast<Eigen::Index>(motors_.size()) + jacobian.rows());
    matrix.setZero();
    for (std::size_t a = 0; a < motors_.size(); ++a) matrix(motors_[a], static_cast<Eigen::Index>(a)) = 1;
    matrix.rightCols(jacobian.rows()) = jacobian.transpose();
    Eigen::CompleteOrthogonalDecomposition<MatrixX> solver;
    solver.setThreshold(1e-10);  // closures may be redundant
    solver.compute(matrix);
    const VectorX solution = solver.solve(forces);
    residual = (matrix * solution - forces).cwiseAbs().maxCoeff();
    return solution.head(static_cast<Eigen::Index>(motors_.size()));
  }

 private:
  /// Couplings: Σ row · q + offset = 0. Other constraints leave the row zero.
  template <class Row>
  void add_linear_row(int e, Row row, double& offset) const {
    const mjModel& m = *model_;
    const mjtNum* poly = m.eq_data + e * mjNEQDATA;
    const int first = m.eq_obj1id[e], second = m.eq_obj2id[e];
    if (m.eq_type[e] == mjEQ_JOINT) {
      row[first] = 1;
      row[second] = -poly[1];
      offset = -poly[0] - m.qpos0[first] + poly[1] * m.qpos0[second];
    } else if (m.eq_type[e] == mjEQ_TENDON) {
      offset = -poly[0];
      for (int w = m.tendon_adr[first]; w < m.tendon_adr[first] + m.tendon_num[first]; ++w) {
        row[m.wrap_objid[w]] = m.wrap_prm[w];
        offset -= m.wrap_prm[w] * m.qpos0[m.wrap_objid[w]];
      }
    }
  }

  template <class Row>
  void set_sparse_row(int r, Row row) const {
    const mjData& d = *data_;
    row.setZero();
    for (int k = 0; k < d.efc_J_rownnz[r]; ++k)
      row[d.efc_J_colind[d.efc_J_rowadr[r] + k]] = d.efc_J[d.efc_J_rowadr[r] + k];
  }

  std::unique_ptr<mjModel, Deleter> model_;
  std::unique_ptr<mjData, Deleter> data_;
  std::vector<int> motors_;
};

int compare(const std::string& mjcf, const std::string& result) {
  ExportedModel model(mjcf);
  const RunResult run = files::read_result_file(result).result;
  std::map<std::string, Eigen::Index> columns, efforts;
  for (std::size_t c = 0; c < run.coordinate_names.size(); ++c)
    columns[run.coordinate_names[c]] = static_cast<Eigen::Index>(c);
  for (std::size_t a = 0; a < run.actuator_names.size(); ++a)
    efforts[run.actuator_names[a]] = static_cast<Eigen::Index>(a);
  std::vector<bool> is_known;
  for (int j = 0; j < model.size(); ++j) is_known.push_back(columns.count(model.joint_name(j)) > 0);
  const auto largest_effort = run.torque.cwiseAbs().maxCoeff();
  double difference = 0, closure = 0, residual = 0;
  for (Eigen::Index k = 0; k < run.torque.rows(); ++k) {
    State state{VectorX::Zero(model.size()), VectorX::Zero(model.size()), VectorX::Zero(model.size())};
    for (int j = 0; j < model.size(); ++j) {
      if (!is_known[static_cast<std::size_t>(j)]) continue;
      const Eigen::Index c = columns[model.joint_name(j)];
      state.q[j] = run.joint_position(k, c);
      state.dq[j] = run.joint_velocity(k, c);
      state.ddq[j] = run.joint_acceleration(k, c);
    }
    model.complete(is_known, state);
    double violation = 0, remainder = 0;
    const VectorX found = model.compute_efforts(state, violation, remainder);
    closure = std::max(closure, violation);
    residual = std::max(residual, remainder);
    for (std::size_t a = 0; a < model.motors().size(); ++a) {
      const Eigen::Index column = efforts.at(model.joint_name(model.motors()[a]));
      difference = std::max(difference, std::abs(found[static_cast<Eigen::Index>(a)] - run.torque(k, column)));
    }
  }
  const double relative = difference / largest_effort, unexplained = residual / largest_effort;
  const bool is_agreement =
      relative <= effort_tolerance && unexplained <= effort_tolerance && closure <= closure_tolerance;
  fmt::print("{}: {} states, {} joints, {} motors: efforts {:.1e} of the peak, unexplained {:.1e}, closures {:.1e}{}\n",
             std::filesystem::path(mjcf).stem().string(), run.torque.rows(), model.size(), model.motors().size(),
             relative, unexplained, closure, is_agreement ? "" : "  FAILED");
  return is_agreement ? 0 : 1;
}

}  // namespace
}  // namespace balance::peers

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fputs("usage: compare_exported MJCF RESULT\n", stderr);
    return 2;
  }
  try {
    return balance::peers::compare(argv[1], argv[2]);
  } catch (const std::exception& error) {
    fmt::print(stderr, "compare_exported: {}: {}\n", argv[1], error.what());
    return 1;
  }
}
