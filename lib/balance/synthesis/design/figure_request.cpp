#include "balance/synthesis/design/figure_request.hpp"

#include "balance/foundation/base/error.hpp"
#include "balance/mechanics/dynamics/force_regressor.hpp"
#include "balance/synthesis/design/assembly_continuation.hpp"
#include "balance/synthesis/design/trajectory_cost.hpp"

#include <stdexcept>

namespace balance::design {

using certificate::ForceFigure;
using certificate::ForceRows;
using certificate::MotionForce;

namespace {

/// @return why it has no bound; empty if it has
std::string read_force(const DesignSpace& space, const ObjectiveTerm& term, const Trajectory& trajectory,
                       MotionForce& force) {
  const std::optional<dynamics::AffineQuantity> quantity =
      dynamics::find_affine_quantity(space.start.mechanism, term.quantity);
  const std::string unknown = "figures of \"" + term.quantity + "\" have no bound";
  if (!quantity) return unknown;
  switch (quantity->kind) {
    case dynamics::AffineQuantity::Kind::torque: force.kind = MotionForce::Kind::torque; break;
    case dynamics::AffineQuantity::Kind::shaking_force: force.kind = MotionForce::Kind::shaking_force; break;
    case dynamics::AffineQuantity::Kind::shaking_moment: force.kind = MotionForce::Kind::shaking_moment; break;
    default: return unknown;
  }
  if (force.kind == MotionForce::Kind::shaking_force) force.component = quantity->component;
  force.about = quantity->about.value_or(trajectory.about).head<2>();
  force.has_named_point = quantity->about.has_value();
  force.actuator = quantity->member;
  force.is_combined = quantity->is_combined;
  return "";
}

class TrajectoryRowModel : public certificate::ForceRowModel {
 public:
  TrajectoryRowModel(const DesignSpace& space, const std::vector<ObjectiveTerm>& terms,
                     const certificate::FigureProblem& problem)
      : space_(space), trajectory_(static_cast<std::size_t>(problem.trajectory)), figures_(terms.size()) {
    for (const ObjectiveTerm& term : terms) names_.push_back(term.quantity);
    for (const MotionForce& force : problem.vanishing)
      names_.push_back(force.kind == MotionForce::Kind::shaking_force ? "shaking_force" : "shaking_moment");
  }

  std::optional<ForceRows> evaluate(const VectorX& x) const override {
    const study::DesignInstance instance = space_.instantiate(x);
    if (!instance.mode_issue.empty() || instance.is_other_mode) return {};
    ForceRows result;
    try {
      Trajectory trajectory = instance.trajectories[trajectory_];
      const TrajectoryCost cost(instance.mechanism, trajectory);
      std::vector<std::optional<std::vector<AffineSeries>>> rows = cost.rows(names_);
      for (std::size_t q = 0; q < rows.size(); ++q) {
        if (!rows[q]) return {};
        auto& force = (q < figures_ ? result.figures : result.vanishing).emplace_back();
        for (AffineSeries& series : *rows[q])
          force.push_back({std::move(series.rows), std::move(series.time_weights), series.components});
      }
    } catch (const std::invalid_argument&) {
      return {};
    }
    result.parameters = dynamics::parameter_values(instance.mechanism);
    return result;
  }

 private:
  const DesignSpace& space_;
  std::size_t trajectory_, figures_;
  std::vector<std::string> names_;
};

}  // namespace

certificate::FigureRequest read_figure_request(const DesignSpace& space, const std::vector<ObjectiveTerm>& terms,
                                               std::string& reason) {
  certificate::FigureRequest request;
  request.keeps_assembly_mode = keeps_assembly_mode(space.start.design, terms);
  for (const ObjectiveTerm& term : terms) {
    if (term.size != ObjectiveTerm::Size::none || term.run != ObjectiveTerm::RunMeasure::figure) {
      reason = "the objective is not a figure of forces";
      return request;
    }
    if (term.deviation_multiple) reason = "the design is robust against tolerances";
    if (term.figure != Statistic::rms && term.figure != Statistic::peak)
      reason = "only rms and peak of forces have a bound";
    const Trajectory* const trajectory = study::find_by_name(space.start.trajectories, term.trajectory);
    const auto index = static_cast<int>(trajectory ? trajectory - space.start.trajectories.data() : -1);
    if (index < 0) reason = "its figure is not that of one motion";
    if (!request.figures.empty() && index != request.trajectory) reason = "its figures are of several motions";
    if (!reason.empty()) return request;
    request.trajectory = index;
    ForceFigure figure;
    figure.weight = term.weight;
    figure.is_peak = term.figure == Statistic::peak;
    reason = read_force(space, term, *trajectory, figure.force);
    if (!reason.empty()) return request;
    request.figures.push_back(figure);
  }
  if (request.figures.empty()) reason = "nothing is minimised";
  return request;
}

std::unique_ptr<certificate::ForceRowModel> make_force_row_model(const DesignSpace& space,
                                                                 const std::vector<ObjectiveTerm>& terms,
                                                                 const certificate::FigureProblem& problem) {
  return std::make_unique<TrajectoryRowModel>(space, terms, problem);
}

}  // namespace balance::design
