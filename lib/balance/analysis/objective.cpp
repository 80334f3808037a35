#include "balance/analysis/objective.hpp"

#include "balance/analysis/finite_trial.hpp"
#include "balance/analysis/objective_pieces.hpp"
#include "balance/analysis/robust_figure.hpp"
#include "balance/analysis/run_figure.hpp"
#include "balance/base/error.hpp"
#include "balance/cost/trajectory_cost.hpp"
#include "balance/design/features.hpp"
#include "balance/result/effort_names.hpp"
#include "balance/simulation/simulate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <memory>
#include <stdexcept>
#include <utility>

namespace balance {

namespace {

/// One term of the sum.
struct Part {
  double weight = 1;
  CostFunction of_parameters;  ///< empty: by simulation
  ObjectiveTerm term;
  std::shared_ptr<const Result> run =
      {};  ///< null: the free numbers may change the motion, or more than the motion counts
};

/// A point in general position: no two numbers at the same part of their bounds.
VectorX somewhere_else(const std::vector<FreeNumber>& numbers) {
  VectorX x(static_cast<Eigen::Index>(numbers.size()));
  double part = 0.41;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    x[static_cast<Eigen::Index>(i)] = numbers[i].lower + part * (numbers[i].upper - numbers[i].lower);
    part = std::fmod(part + 0.382, 0.8) + 0.1;
  }
  return x;
}

/// The free numbers change neither the places of joints, discs and springs nor the motion along the trajectory.
bool same_motion(const Trial& a, const Trial& b, const ObjectiveTerm& term, const LooseSprings& loose) {
  const VectorX one = designing::geometry(a.mechanism, loose), other = designing::geometry(b.mechanism, loose);
  if (one.size() != other.size() || (one - other).norm() > 1e-12 * one.norm()) return false;
  const Result first = simulate(a.mechanism, trajectory_of(a, term));
  const Result second = simulate(b.mechanism, trajectory_of(b, term));
  if (first.outcome.status != MotionStatus::done || second.outcome.status != MotionStatus::done) return false;
  const auto alike = [](const Samples& p, const Samples& q) {
    return p.rows() == q.rows() && (p - q).norm() <= 1e-9 * (1 + p.norm());
  };
  return first.time.isApprox(second.time) && alike(first.joint_position, second.joint_position) &&
         alike(first.joint_velocity, second.joint_velocity);
}

/// Whatever the free numbers are.
bool stays_the_same(const DesignSpace& space, const Trial& start, const ObjectiveTerm& term,
                    const LooseSprings& loose) {
  try {
    return same_motion(start, finite_trial(space, somewhere_else(space.start.free_numbers)), term, loose);
  } catch (const SpecError&) {
    return false;  // with these numbers an expression of the spec has no value
  } catch (const std::invalid_argument&) {
    return false;  // or there is no motion
  }
}

CostFunction linear(VectorX coefficients) {
  return [coefficients = std::move(coefficients)](const VectorX& parameters, VectorX* gradient) {
    if (gradient != nullptr) *gradient = coefficients;
    return coefficients.dot(parameters);
  };
}

/// Along a motion that stays the same; empty if it does not, or if the quantity is not linear in the parameters.
CostFunction along_fixed_motion(const DesignSpace& space, const Trial& start, const ObjectiveTerm& term,
                                const LooseSprings& loose) {
  const Trajectory& trajectory = trajectory_of(start, term);
  if (term.plus || term.run != ObjectiveTerm::Run::figure || depends_on_mechanism(trajectory)) return {};
  if (depends_on_masses(trajectory) || !stays_the_same(space, start, term, loose)) return {};
  const TrajectoryCost cost(start.mechanism, trajectory, loose);
  return cost.figure(term.figure, term.quantity).value_or(CostFunction{});
}

/// Absolute values and norms of affine functions are convex; how far values lie apart is, too; a minimum is not.
bool is_convex(const ObjectiveTerm& term) {
  return term.size != ObjectiveTerm::Size::none || term.figure != Figure::range ||
         array_name(term.quantity).starts_with("torque");
}

std::function<double(const VectorX&, VectorX*)> sum_of_parameters(std::vector<Part> parts) {
  return [parts = std::move(parts)](const VectorX& parameters, VectorX* gradient) {
    double sum = 0;
    if (gradient != nullptr) gradient->setZero(parameters.size());
    VectorX own;
    for (const Part& part : parts) {
      sum += part.weight * part.of_parameters(parameters, gradient != nullptr ? &own : nullptr);
      if (gradient != nullptr) *gradient += part.weight * own;
    }
    return sum;
  };
}

/// A search asks for a simulated figure at the same numbers again and again: the last few values are kept.
std::function<double(const VectorX&)> with_memory(std::function<double(const VectorX&)> figure) {
  constexpr std::size_t max_kept = 16;
  using Known = std::deque<std::pair<VectorX, double>>;
  return [figure = std::move(figure), known = std::make_shared<Known>()](const VectorX& x) {
    for (const auto& [at, value] : *known)
      if (at == x) return value;
    const double value = figure(x);
    known->emplace_front(x, value);
    if (known->size() > max_kept) known->pop_back();
    return value;
  };
}

std::function<double(const VectorX&)> sum_of_variables(const DesignSpace& space, std::vector<Part> parts,
                                                       const LooseSprings& loose) {
  return with_memory([space, parts = std::move(parts), loose](const VectorX& x) {
    const Trial trial = finite_trial(space, x);
    const VectorX parameters = parameter_values(trial.mechanism, loose);
    double sum = 0;
    for (const Part& part : parts)
      sum += part.weight * (part.of_parameters ? part.of_parameters(parameters, nullptr)
                            : part.term.plus   ? robust_figure(space, x, part.term).value
                            : part.run         ? run_figure(trial.mechanism, *part.run, part.term)
                                               : by_simulation(trial, part.term));
    return sum;
  });
}

/// The first trajectory of the terms that cannot be followed, and why.
std::function<std::string(const VectorX&)> trouble_with(const DesignSpace& space, std::vector<ObjectiveTerm> terms) {
  return [space, terms = std::move(terms)](const VectorX& x) -> std::string {
    const Trial trial = finite_trial(space, x);
    for (const ObjectiveTerm& term : terms) {
      if (term.size != ObjectiveTerm::Size::none) continue;
      const Result result = simulate(trial.mechanism, trajectory_of(trial, term));
      if (result.outcome.status != MotionStatus::done)
        return fmt::format("'{}' cannot be followed: {}", term.trajectory, result.outcome.reason);
    }
    return "";
  };
}

/// Whether the mechanism has the term's quantity at all, where it can be told.
void require_quantity(const Trial& trial, const ObjectiveTerm& term) {
  try {
    by_simulation(trial, term);
  } catch (const SpecError&) {
    // there is no motion with these numbers; with others there may be
  }
}

/// Whether the run has deviations, and few enough of them.
void require_deviations(const DesignSpace& space, const VectorX& start, const ObjectiveTerm& term) {
  try {
    robust_figure(space, start, term);
  } catch (const SpecError&) {
    // as above
  }
}

/// Where places and singularities are all that counts, and the free numbers do not change the motion: the run.
std::shared_ptr<const Result> fixed_run(const DesignSpace& space, const Trial& start, const ObjectiveTerm& term,
                                        const LooseSprings& loose) {
  const bool of_motion = term.run == ObjectiveTerm::Run::mobility || term.run == ObjectiveTerm::Run::clearance;
  if (!of_motion || depends_on_masses(trajectory_of(start, term)) || !stays_the_same(space, start, term, loose))
    return {};
  return std::make_shared<const Result>(simulate(start.mechanism, trajectory_of(start, term)));
}

/// The figure of such a run where the places that it is of do not change either.
std::optional<double> constant_value(const DesignSpace& space, const Trial& start, const Part& part) {
  std::optional<double> constant;
  if (!part.run) return constant;
  const auto value = [&](const Trial& trial) { return run_figure(trial.mechanism, *part.run, part.term); };
  const double here = value(start), elsewhere = value(space.trial(somewhere_else(space.start.free_numbers)));
  if (here == elsewhere) constant = here;
  return constant;
}

CostFunction constant(double value) {
  return [value](const VectorX& parameters, VectorX* gradient) {
    if (gradient != nullptr) gradient->setZero(parameters.size());
    return value;
  };
}

constexpr long few_samples = 201;

/// One term; nothing where the trajectory cannot be followed.
std::optional<LinearFigure> figure_at(const Trial& trial, const ObjectiveTerm& term, const LooseSprings& loose,
                                      FigureSamples samples) {
  LinearFigure figure{term.weight, {}, term.figure, {}};
  if (term.size != ObjectiveTerm::Size::none) {
    figure.coefficients = size_coefficients(term.size, trial.mechanism, loose);
    return figure;
  }
  Trajectory trajectory = trajectory_of(trial, term);
  if (samples == FigureSamples::few) trajectory.samples = std::min(trajectory.samples, few_samples);
  auto series = TrajectoryCost(trial.mechanism, trajectory, loose).rows(term.quantity);
  if (!series) return std::nullopt;
  figure.series = std::move(*series);
  return figure;
}

/// A convex function of the parameters, whatever the motion is.
bool is_of_parameters(const Trial& trial, const ObjectiveTerm& term) {
  if (term.size != ObjectiveTerm::Size::none) return term.weight >= 0;
  if (term.plus) return false;
  return term.run == ObjectiveTerm::Run::figure && term.weight >= 0 &&
         (term.figure == Figure::rms || term.figure == Figure::peak) &&
         is_linear_quantity(trial.mechanism, term.quantity) && !depends_on_masses(trajectory_of(trial, term)) &&
         !depends_on_mechanism(trajectory_of(trial, term));
}

}  // namespace

std::function<std::optional<std::vector<LinearFigure>>(const VectorX& x)> build_figures(
    const DesignSpace& space, const std::vector<ObjectiveTerm>& terms, const LooseSprings& loose,
    FigureSamples samples) {
  const Trial start = space.trial(space.start_values());
  const auto all = [&](const ObjectiveTerm& term) { return is_of_parameters(start, term); };
  if (!std::all_of(terms.begin(), terms.end(), all)) return {};
  return [space, terms, loose, samples](const VectorX& x) -> std::optional<std::vector<LinearFigure>> {
    std::vector<LinearFigure> figures;
    try {
      const Trial trial = finite_trial(space, x);
      for (const ObjectiveTerm& term : terms) {
        std::optional<LinearFigure> figure = figure_at(trial, term, loose, samples);
        if (!figure) return std::nullopt;
        figures.push_back(std::move(*figure));
      }
    } catch (const SpecError&) {
      return std::nullopt;  // an expression of the spec has no value here
    } catch (const std::invalid_argument&) {
      return std::nullopt;  // nor is there a motion
    }
    return figures;
  };
}

Objective build_objective(const DesignSpace& space, const std::vector<ObjectiveTerm>& terms, const VectorX& start,
                          const LooseSprings& loose) {
  const Trial before = space.trial(start);
  std::vector<Part> parts;
  Objective objective;
  objective.convex = objective.size = true;
  // magnitudes, distances and masses
  if (std::all_of(terms.begin(), terms.end(), [](const ObjectiveTerm& term) { return term.weight >= 0; }))
    objective.lower_bound = 0;
  for (const ObjectiveTerm& term : terms) {
    const bool size = term.size != ObjectiveTerm::Size::none;
    Part part{term.weight,
              size ? linear(size_coefficients(term.size, before.mechanism, loose))
                   : along_fixed_motion(space, before, term, loose),
              term};
    if (!part.of_parameters) require_quantity(before, term);  // says now what does not exist
    if (term.plus) require_deviations(space, start, term);
    if (!size) part.run = fixed_run(space, before, term, loose);
    const std::optional<double> fixed = constant_value(space, before, part);
    if (fixed) part.of_parameters = constant(*fixed);
    objective.constant = fixed && terms.size() == 1;
    objective.convex = objective.convex && part.of_parameters && is_convex(term);
    objective.size = objective.size && size;
    objective.name +=
        (parts.empty() ? "" : " + ") + (term.weight == 1 ? "" : fmt::format("{:g} ", term.weight)) + name_of(term);
    parts.push_back(std::move(part));
  }
  const bool cheap = std::all_of(parts.begin(), parts.end(), [](const Part& p) { return bool(p.of_parameters); });
  if (terms.size() == 1 && terms[0].size != ObjectiveTerm::Size::none)
    objective.unit = terms[0].size == ObjectiveTerm::Size::added_inertia ? "kg m^2" : "kg";
  if (cheap)
    objective.of_parameters = sum_of_parameters(std::move(parts));
  else
    objective.of_variables = sum_of_variables(space, std::move(parts), loose);
  objective.trouble = trouble_with(space, terms);
  return objective;
}

VectorX is_added(const Mechanism& mechanism, const std::vector<Parameter>& parameters) {
  VectorX added(static_cast<Eigen::Index>(parameters.size()));
  for (std::size_t p = 0; p < parameters.size(); ++p) {
    const auto index = static_cast<std::size_t>(parameters[p].index);
    const bool counterweight = parameters[p].bearer == Bearer::attachment &&
                               mechanism.attachments[index].kind == AttachmentKind::counterweight;
    added[static_cast<Eigen::Index>(p)] = counterweight || parameters[p].bearer == Bearer::disc ? 1 : 0;
  }
  return added;
}

VectorX mass_coefficients(const std::vector<Parameter>& parameters) {
  VectorX coefficients(static_cast<Eigen::Index>(parameters.size()));
  for (std::size_t p = 0; p < parameters.size(); ++p)
    coefficients[static_cast<Eigen::Index>(p)] = parameters[p].kind == ParameterKind::mass ? 1 : 0;
  return coefficients;
}

VectorX inertia_coefficients(const std::vector<Parameter>& parameters) {
  VectorX coefficients(static_cast<Eigen::Index>(parameters.size()));
  for (std::size_t p = 0; p < parameters.size(); ++p)
    coefficients[static_cast<Eigen::Index>(p)] = parameters[p].kind != ParameterKind::moment_of_inertia ? 0
                                                 : parameters[p].symbol == "J"                          ? 1
                                                                                                        : 0.5;
  return coefficients;
}

VectorX size_coefficients(ObjectiveTerm::Size size, const Mechanism& mechanism, const LooseSprings& loose) {
  const auto parameters = list_parameters(mechanism, loose);
  VectorX coefficients =
      size == ObjectiveTerm::Size::added_inertia ? inertia_coefficients(parameters) : mass_coefficients(parameters);
  if (size != ObjectiveTerm::Size::total_mass) coefficients.array() *= is_added(mechanism, parameters).array();
  return coefficients;
}

}  // namespace balance
