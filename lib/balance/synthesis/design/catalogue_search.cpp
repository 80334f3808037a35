#include "balance/synthesis/design/catalogue_search.hpp"

#include "balance/foundation/base/cpu_time.hpp"
#include "balance/foundation/base/error.hpp"
#include "balance/foundation/base/spelling.hpp"
#include "balance/motion/simulation/run_figure.hpp"
#include "balance/synthesis/design/catalogue_program.hpp"
#include "balance/synthesis/design/load_case_study.hpp"
#include "balance/synthesis/design/required_motions.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <queue>
#include <stdexcept>

namespace balance::design {

bool has_free_rows(const Study& study) {
  return std::any_of(study.catalogue_choices.begin(), study.catalogue_choices.end(),
                     [](const study::CatalogueChoice& choice) { return choice.is_free; });
}

namespace {

/// Relative distance from the bound at which rows and places count as proved best.
constexpr double proved_row_gap = 1e-3;
/// … to which the search goes on for a short time.
constexpr double refined_row_gap = 1e-6;
/// The same, as a fraction of the objective at the start, for designs whose objective nearly vanishes.
constexpr double vanishing_objective = 1e-6;
/// Share of the time for the search over rows; the rest is for the design with the best ones.
constexpr double row_search_share = 0.7;
/// The search is refined for as long as it took, at least and at most for these times [s].
constexpr double min_refinement_seconds = 0.2, max_refinement_seconds = 2;
/// Shares of the time for first designs before the search over rows, and for designs during it.
constexpr double first_design_share = 0.05, candidate_share = 0.1;
/// The figures of the program and of a simulation agree to this fraction.
constexpr double figure_agreement_tolerance = 1e-6;

/// Figures of a design by simulation.
struct SimulatedDesign {
  double value = std::numeric_limits<double>::quiet_NaN();
  double violation = std::numeric_limits<double>::infinity();  ///< of the worst limit, relative to its bound
  std::vector<LimitOutcome> limits;
  bool is_within_limits() const { return violation <= limit_tolerance; }
};

class RowSearch {
 public:
  RowSearch(const DesignSpace& space, const DesignStudyOptions& options, const FixedRowStudy& study)
      : space_(space),
        options_(options),
        study_(study),
        terms_(options.minimize.empty() ? space.start.design.minimize : options.minimize),
        start_time_(thread_cpu_time()) {
    for (const study::CatalogueChoice& choice : space.start.catalogue_choices) {
      start_rows_.push_back(choice.row);
      if (choice.is_free) report_.combinations *= choice.rows();
    }
    report_.is_searched = true;
  }

  DesignReport run() {
    if (space_.start.design.cases.size() > 0)
      throw std::invalid_argument("load cases need given parts: name one with 'part' under 'catalogue'");
    const bool has_goals = !options_.goals.empty() || !space_.start.design.goals.empty();
    if (has_goals && space_.start.free_numbers.empty())
      throw std::invalid_argument("a goal needs free numbers besides the rows of catalogues");
    if (!has_goals && terms_.empty() && space_.start.design.subject_to.empty())
      throw std::invalid_argument("a design needs a goal, something to minimize or limits");
    std::optional<CatalogueProgram> program;
    if (has_goals) {
      report_.no_bound_reason = "there is a goal";
    } else if (!has_run_figure()) {
      report_.no_bound_reason = "the objective is not a figure of a motion";
    } else {
      try {
        program.emplace(space_, terms_);
      } catch (const CatalogueProgramError& error) {
        report_.no_bound_reason = error.what();
      }
    }
    if (program && !branch_and_bound(*program)) program.reset();
    if (!program) try_rows(has_goals);
    return finish(has_goals);
  }

 private:
  bool has_run_figure() const {
    return std::any_of(terms_.begin(), terms_.end(),
                       [](const ObjectiveTerm& term) { return term.size == ObjectiveTerm::Size::none; });
  }
  double elapsed() const { return thread_cpu_time() - start_time_; }
  bool is_time_up(double share) {
    if (options_.on_progress && !is_interrupted_) {
      SearchProgress progress{elapsed(), options_.search.max_time};
      progress.evaluations = static_cast<int>(std::min<long>(report_.branches, std::numeric_limits<int>::max()));
      is_interrupted_ = !options_.on_progress(progress);
    }
    return is_interrupted_ || elapsed() > share * options_.search.max_time;
  }

  /// Objective and limits by simulation.
  SimulatedDesign simulate_design(const std::vector<int>& rows, const VectorX& x) const {
    SimulatedDesign design;
    try {
      const DesignSpace chosen = space_.with_rows(rows);
      const study::DesignInstance instance = instantiate_checked(chosen, x);
      if (!find_validation_issue(instance.mechanism).empty()) return design;
      const auto figure = [&](const ObjectiveTerm& term) {
        if (is_size_of_parts(term.size)) return term.weight * sum_of_parts(term.size, chosen.start.catalogue_choices);
        if (term.size != ObjectiveTerm::Size::none) return term.weight * size_of(instance.mechanism, term.size);
        return term.weight * simulation::simulate_figure(instance, term);
      };
      double sum = 0;
      for (const ObjectiveTerm& term : terms_) sum += figure(term);
      double worst = 0;
      for (const study::FigureLimit& limit : space_.start.design.subject_to) {
        LimitOutcome outcome;
        outcome.value = 0;
        for (const ObjectiveTerm& term : limit.terms) outcome.value += figure(term);
        const double excess = (limit.is_lower ? -1 : 1) * (outcome.value - limit.bound);
        outcome.violation = std::isnan(excess) ? std::numeric_limits<double>::infinity()
                                               : excess / (limit.bound == 0 ? 1 : std::abs(limit.bound));
        outcome.is_active = outcome.violation > -1e-6;
        worst = std::max(worst, outcome.violation);
        design.limits.push_back(outcome);
      }
      design.value = sum;
      design.violation = std::isnan(sum) ? std::numeric_limits<double>::infinity() : worst;
    } catch (const SpecError&) {
      // an expression has no value here
    } catch (const std::invalid_argument&) {
      // there is no motion
    }
    return design;
  }

  static double size_of(const Mechanism& mechanism, ObjectiveTerm::Size size) {
    double sum = 0;
    const bool is_inertia = size == ObjectiveTerm::Size::added_inertia;
    for (const Attachment& attachment : mechanism.attachments)
      if (attachment.kind == AttachmentKind::counterweight && !is_inertia) sum += attachment.mass;
    for (const Disc& disc : mechanism.discs) sum += is_inertia ? disc.axis.dot(disc.inertia * disc.axis) : disc.mass;
    if (size == ObjectiveTerm::Size::total_mass) return total_mass(mechanism);
    return sum;
  }

  /// Keeps it if it is better than the best so far.
  bool consider(const std::vector<int>& rows, const VectorX& x, const SimulatedDesign& design) {
    if (std::isnan(design.value)) return false;
    const bool is_allowed = design.is_within_limits(), was_allowed = best_ && best_->is_within_limits();
    const bool is_better = !best_ || (is_allowed && !was_allowed) ||
                           (is_allowed && was_allowed && design.value < best_->value) ||
                           (!is_allowed && !was_allowed && design.violation < best_->violation);
    if (!is_better) return false;
    best_ = design, best_rows_ = rows, best_x_ = x;
    return true;
  }

  /// Below this value a design would be better than the best one by more than a gap.
  double cutoff(double gap) const {
    if (!best_ || !best_->is_within_limits()) return std::numeric_limits<double>::infinity();
    return best_->value - std::max(gap * std::abs(best_->value), vanishing_objective * scale_);
  }

  /// @return false if the program's figures are not those of simulations
  bool branch_and_bound(const CatalogueProgram& program) {
    const auto is_later = [](const CatalogueBox& a, const CatalogueBox& b) { return a.bound > b.bound; };
    std::priority_queue<CatalogueBox, std::vector<CatalogueBox>, decltype(is_later)> open(is_later);
    const SimulatedDesign at_start = simulate_design(start_rows_, space_.start_values());
    scale_ = std::isnan(at_start.value) ? 0 : std::abs(at_start.value);
    consider(start_rows_, space_.start_values(), at_start);
    if (!find_first_designs(program)) return false;
    open.push(program.root());
    double decided = std::numeric_limits<double>::infinity();  // least bound of what is not searched further
    double gap = proved_row_gap, refinement_end = std::numeric_limits<double>::infinity();
    double candidate_seconds = 0;
    const bool has_places = !space_.start.free_numbers.empty();
    while (!open.empty()) {
      if (open.top().bound >= cutoff(gap)) {
        if (gap == refined_row_gap || decided < cutoff(refined_row_gap)) break;
        gap = refined_row_gap;
        refinement_end = elapsed() + std::clamp(elapsed(), min_refinement_seconds, max_refinement_seconds);
        continue;
      }
      if (report_.branches % 16 == 0 && (elapsed() > refinement_end || is_time_up(row_search_share))) break;
      const CatalogueBox box = open.top();
      open.pop();
      ++report_.branches;
      const double target = cutoff(refined_row_gap);
      CatalogueBound bound = program.bound(box, target);
      if (!bound.is_feasible) {
        decided = std::min(decided, target);  // nothing is below it
        continue;
      }
      if (bound.lower >= cutoff(gap)) {
        decided = std::min(decided, bound.lower);
        continue;
      }
      const bool is_point = bound.halves.empty();
      if (!has_places || is_point || candidate_seconds <= candidate_share * elapsed()) {
        const double start = elapsed();
        CatalogueDesign candidate = program.evaluate(bound.rows, bound.x);
        if (is_point && candidate.violation <= 0) decided = std::min(decided, bound.lower);
        if (!try_candidate(program, std::move(candidate))) return false;
        candidate_seconds += elapsed() - start;
      }
      if (is_point) continue;
      for (CatalogueBox& half : bound.halves.front()) {
        half.bound = bound.lower;
        open.push(std::move(half));
      }
    }
    const double rest = open.empty() ? std::numeric_limits<double>::infinity() : open.top().bound;
    report_.lower_bound = std::min(decided, rest);
    if (best_ && best_->is_within_limits()) report_.lower_bound = std::min(report_.lower_bound, best_->value);
    report_.is_out_of_time = !open.empty() && open.top().bound < cutoff(proved_row_gap);
    return true;
  }

  /// Improves it if that may make it the best one.
  /// @return false if the program's figures are not those of simulations
  bool try_candidate(const CatalogueProgram& program, CatalogueDesign candidate) {
    constexpr int max_attempts = 2;
    const double target = best_ && best_->is_within_limits() ? best_->value : std::numeric_limits<double>::infinity();
    if ((candidate.value < target || candidate.violation > 0 || !space_.start.free_numbers.empty()) &&
        attempts_[candidate.rows] < max_attempts) {
      ++attempts_[candidate.rows];
      candidate = program.improve(candidate);
    }
    if (!(candidate.violation <= 0 && candidate.value < target * (1 - 1e-9))) return true;
    const SimulatedDesign simulated = simulate_design(candidate.rows, candidate.x);
    if (!(std::abs(simulated.value - candidate.value) <=
          figure_agreement_tolerance * (std::abs(candidate.value) + scale_))) {
      report_.no_bound_reason = "its figures differ from those of the forces' linear model";
      return false;
    }
    if (consider(candidate.rows, candidate.x, simulated)) ++report_.solved;
    return true;
  }

  /// Designs with rows spread over each catalogue, then with rows like the best one: without a good design little can be
  /// left out of the search.
  /// @return as try_candidate
  bool find_first_designs(const CatalogueProgram& program) {
    if (space_.start.free_numbers.empty()) return true;
    constexpr int spread = 40;
    const auto& choices = space_.start.catalogue_choices;
    for (const bool is_near : {false, true})
      for (std::size_t k = 0; k < choices.size(); ++k) {
        if (!choices[k].is_free) continue;
        const std::vector<int>& order = program.similar_rows(static_cast<int>(k));
        const int count = static_cast<int>(order.size());
        const auto own = std::find(order.begin(), order.end(), (best_ ? best_rows_ : start_rows_)[k]) - order.begin();
        const int step = is_near ? 1 : std::max(1, count / spread);
        for (int i = 0; i < std::min(spread, count); ++i) {
          if (is_time_up(first_design_share)) return true;
          const int at = is_near ? static_cast<int>(own) + i - spread / 2 : i * step;
          if (at < 0 || at >= count) continue;
          CatalogueDesign candidate;
          candidate.rows = best_ ? best_rows_ : start_rows_;
          candidate.rows[k] = order[static_cast<std::size_t>(at)];
          candidate.x = best_ ? best_x_ : space_.start_values();
          if (!try_candidate(program, program.evaluate(candidate.rows, candidate.x))) return false;
        }
      }
    return true;
  }

  /// Combinations in the order of their cost; equal ones as in the catalogues.
  std::vector<std::vector<int>> list_combinations() {
    constexpr double max_listed = 2e6;
    struct Combination {
      double cost = 0;
      std::vector<int> rows;
    };
    std::vector<Combination> all(1);
    for (const study::CatalogueChoice& choice : space_.start.catalogue_choices) {
      std::vector<Combination> longer;
      for (const Combination& one : all)
        for (int r = 0; r < choice.rows(); ++r) {
          if (!choice.is_free && r != choice.row) continue;
          if (static_cast<double>(longer.size()) > max_listed) break;
          longer.push_back({one.cost + cost_of(choice, r), one.rows});
          longer.back().rows.push_back(r);
        }
      all = std::move(longer);
    }
    std::stable_sort(all.begin(), all.end(),
                     [](const Combination& a, const Combination& b) { return a.cost < b.cost; });
    std::vector<std::vector<int>> sorted;
    for (Combination& one : all) {
      costs_.push_back(one.cost);
      sorted.push_back(std::move(one.rows));
    }
    return sorted;
  }

  double cost_of(const study::CatalogueChoice& choice, int row) const {
    double sum = 0;
    for (const ObjectiveTerm& term : terms_)
      if (is_size_of_parts(term.size))
        sum += term.weight * (term.size == ObjectiveTerm::Size::price ? choice.price_of(row) : choice.mass_of(row));
    return sum;
  }

  bool keeps_sums(const std::vector<int>& rows) const {
    const auto& choices = space_.start.catalogue_choices;
    for (const study::FigureLimit& limit : space_.start.design.subject_to) {
      if (!std::all_of(limit.terms.begin(), limit.terms.end(),
                       [](const ObjectiveTerm& term) { return is_size_of_parts(term.size); }))
        continue;
      double sum = 0;
      for (const ObjectiveTerm& term : limit.terms)
        for (std::size_t k = 0; k < choices.size(); ++k)
          sum += term.weight *
                 (term.size == ObjectiveTerm::Size::price ? choices[k].price_of(rows[k]) : choices[k].mass_of(rows[k]));
      const double tolerance = limit_tolerance * std::max(1.0, std::abs(limit.bound));
      if (limit.is_lower ? sum < limit.bound - tolerance : sum > limit.bound + tolerance) return false;
    }
    return true;
  }

  /// A design for each combination of rows.
  void try_rows(bool has_goals) {
    best_.reset();
    const bool has_places = !space_.start.free_numbers.empty();
    const bool is_cost_only =
        !has_run_figure() && std::all_of(terms_.begin(), terms_.end(),
                                         [](const ObjectiveTerm& term) { return is_size_of_parts(term.size); });
    const std::vector<std::vector<int>> combinations = list_combinations();
    bool is_complete = static_cast<double>(combinations.size()) >= report_.combinations, are_all_proved = true;
    for (std::size_t i = 0; i < combinations.size(); ++i) {
      if (is_time_up(row_search_share) && report_.solved > 0) {
        is_complete = false;
        report_.is_out_of_time = true;
        break;
      }
      if (is_cost_only && best_ && best_->is_within_limits() && best_is_balanced_ && costs_[i] >= best_->value) break;
      if (!keeps_sums(combinations[i])) continue;
      ++report_.solved;
      if (!has_places) {
        consider(combinations[i], VectorX(0), simulate_design(combinations[i], VectorX(0)));
        best_is_balanced_ = true;
        continue;
      }
      DesignStudyOptions quick = options_;
      quick.is_single_pass = true;
      quick.compare_trajectories = false;
      quick.search.max_time = std::max(
          0.05, std::min(row_search_share * options_.search.max_time - elapsed(), 0.1 * options_.search.max_time));
      const DesignReport one = study_(space_.with_rows(combinations[i]), quick);
      const DesignOutcome& outcome = one.outcome;
      const bool is_decided = outcome.optimality == Optimality::proved_global || outcome.is_proved_infeasible;
      const bool is_balanced = is_success(outcome);
      are_all_proved = are_all_proved && (is_decided || (is_cost_only && is_balanced && outcome.within_limits));
      if (outcome.x.size() == 0 || (best_ && best_is_balanced_ && !is_balanced)) continue;
      if (best_ && is_balanced && !best_is_balanced_) best_.reset();
      SimulatedDesign design = simulate_design(combinations[i], outcome.x);
      if (has_goals && !is_balanced) design.value = outcome.residuals_after.norm();
      if (consider(combinations[i], outcome.x, design)) best_is_balanced_ = is_balanced;
    }
    report_.is_proved = is_complete && are_all_proved && best_ && best_->is_within_limits() && best_is_balanced_;
    if (report_.is_proved) report_.lower_bound = best_->value;
  }

  /// The design with the best rows, from the best places.
  DesignReport finish(bool has_goals) {
    if (!best_) best_rows_ = start_rows_, best_x_ = space_.start_values();
    std::vector<int> all(space_.start.free_numbers.size());
    std::iota(all.begin(), all.end(), 0);
    const DesignSpace chosen = space_.with_rows(best_rows_).fix_others(best_x_, all);
    DesignReport report = all.empty() ? make_fixed_report() : solve_chosen(chosen, has_goals);
    report.before = space_.start_values();
    report.free_numbers = space_.start.free_numbers;
    report_.choices = chosen.start.catalogue_choices;
    report.catalogue = report_;
    if (report.outcome.status == DesignStatus::unsolved) return report;
    measure_design(chosen, report);
    DesignReport before;
    before.outcome.x = before.before = report.before;
    measure_design(space_, before);
    report.study_before = before.study_before;
    report.mass_before = before.mass_before, report.inertia_before = before.inertia_before;
    if (options_.compare_trajectories) {
      report.comparisons.clear();
      compare_trajectories(report);
    }
    if (!terms_.empty()) report.outcome.start_objective = simulate_design(start_rows_, space_.start_values()).value;
    claim(report);
    report.catalogue = report_;
    return report;
  }

  DesignReport solve_chosen(const DesignSpace& chosen, bool has_goals) {
    DesignStudyOptions last = options_;
    last.is_single_pass = std::isfinite(report_.lower_bound);
    last.compare_trajectories = false;
    last.search.max_time = std::max(0.5, options_.search.max_time - elapsed());
    DesignReport report = study_(chosen, last);
    DesignOutcome& outcome = report.outcome;
    if (has_goals || !best_ || outcome.x.size() == 0) return report;
    // below the bound: a limit is left by what counts as round-off, beyond which a spring hangs slack
    const bool is_beyond_bound =
        !terms_.empty() && outcome.objective < report_.lower_bound * (1 - 1e-9) && std::isfinite(report_.lower_bound);
    const bool is_worse = is_beyond_bound || (best_->is_within_limits() && !outcome.within_limits) ||
                          (!terms_.empty() && best_->is_within_limits() && outcome.objective > best_->value);
    if (!is_worse) return report;
    outcome.x = best_x_;
    outcome.objective = terms_.empty() ? outcome.objective : best_->value;
    outcome.limits = best_->limits;
    outcome.within_limits = true;
    outcome.status = DesignStatus::no_goal;
    outcome.is_proved_infeasible = false;
    outcome.reason.clear();
    outcome.edges.clear();
    return report;
  }

  /// Nothing is free besides the rows.
  DesignReport make_fixed_report() const {
    DesignReport report;
    DesignOutcome& outcome = report.outcome;
    outcome.x = VectorX(0);
    outcome.status = DesignStatus::no_goal;
    if (!best_) {
      outcome.status = DesignStatus::unsolved;
      outcome.reason = "no row gives a mechanism whose figures have values";
      return report;
    }
    outcome.objective = terms_.empty() ? std::numeric_limits<double>::quiet_NaN() : best_->value;
    outcome.limits = best_->limits;
    outcome.within_limits = best_->is_within_limits();
    if (!outcome.within_limits) {
      outcome.status = DesignStatus::compromise;
      outcome.reason = "no rows were found that keep all limits";
    }
    return report;
  }

  /// What is known about the design from the search over rows.
  void claim(DesignReport& report) {
    DesignOutcome& outcome = report.outcome;
    const bool is_good = is_design(outcome) && std::isfinite(outcome.objective);
    if (std::isfinite(report_.lower_bound) && is_good) {
      const double gap = outcome.objective - report_.lower_bound;
      report_.is_proved =
          gap <= std::max(proved_row_gap * std::abs(outcome.objective), 2 * vanishing_objective * scale_);
      outcome.lower_bound = std::min(report_.lower_bound, outcome.objective);
      outcome.optimality = report_.is_proved        ? Optimality::proved_global
                           : report_.is_out_of_time ? Optimality::budget_exhausted
                                                    : Optimality::local_optimum;
    } else {
      report_.is_proved = report_.is_proved && is_good;
      if (!report_.is_proved && outcome.optimality == Optimality::proved_global)
        outcome.optimality = Optimality::local_optimum;  // for these rows only
      if (!report_.is_proved) outcome.lower_bound = std::numeric_limits<double>::quiet_NaN();
      if (report_.is_proved) outcome.optimality = Optimality::proved_global, outcome.lower_bound = outcome.objective;
    }
    if (report_.is_out_of_time && !report_.is_proved && is_design(outcome))
      outcome.optimality = Optimality::budget_exhausted;
    outcome.solution_set = {};
    outcome.search_summary =
        fmt::format("{} of {:.6g} combinations of rows solved", report_.solved, report_.combinations) +
        (report_.branches > 0 ? fmt::format(", {} sets of rows and places bounded", report_.branches) : "");
  }

  const DesignSpace& space_;
  const DesignStudyOptions& options_;
  const FixedRowStudy& study_;
  const std::vector<ObjectiveTerm> terms_;
  double start_time_, scale_ = 0;
  bool is_interrupted_ = false, best_is_balanced_ = false;
  std::vector<int> start_rows_;
  std::vector<double> costs_;
  std::optional<SimulatedDesign> best_;
  std::vector<int> best_rows_;
  VectorX best_x_;
  std::map<std::vector<int>, int> attempts_;  ///< to improve a design with these rows
  CatalogueReport report_;
};

}  // namespace

DesignReport run_catalogue_study(const DesignSpace& space, const DesignStudyOptions& options,
                                 const FixedRowStudy& study) {
  return RowSearch(space, options, study).run();
}

}  // namespace balance::design
