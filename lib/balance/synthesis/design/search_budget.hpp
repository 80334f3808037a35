#pragma once
/// Time limit of a design computation, and statistics of its effort.

#include "balance/foundation/base/cpu_time.hpp"
#include "balance/synthesis/design/design_problem.hpp"
#include "balance/synthesis/design/incumbent.hpp"

#include <algorithm>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

namespace balance::design {

/// Computing time that a search and a bound share, and whether the design was interrupted.
class DesignClock {
 public:
  /// @param seconds until the end, at most those of the problem
  DesignClock(const DesignProblem& problem, double seconds)
      : problem_(problem), seconds_(seconds), start_time_(thread_cpu_time()) {}

  double elapsed() const { return thread_cpu_time() - start_time_; }        ///< [s]
  double remaining() const { return std::max(0.0, seconds_ - elapsed()); }  ///< [s]
  bool was_interrupted() const { return is_interrupted_; }                  ///< when last asked
  /// Asks on_progress.
  bool is_interrupted() {
    return is_interrupted_ = is_interrupted_ ||
                             (problem_.on_progress && !problem_.on_progress({elapsed(), problem_.search.max_time}));
  }

 private:
  const DesignProblem& problem_;
  double seconds_, start_time_;
  bool is_interrupted_ = false;
};

class SearchBudget {
 public:
  /// @param on_progress as DesignProblem::on_progress
  explicit SearchBudget(double seconds, std::function<bool(const SearchProgress&)> on_progress = {})
      : on_progress_(std::move(on_progress)),
        seconds_(seconds),
        start_time_(thread_cpu_time()),
        end_time_(start_time_ + seconds) {}

  /// [s], positive.
  double remaining_time() const {
    return is_interrupted_ ? min_remaining_time : std::max(min_remaining_time, end_time_ - thread_cpu_time());
  }
  /// Whether the time is used up or the search was interrupted; sets `stopped`.
  bool is_spent() {
    if (is_interrupted() || thread_cpu_time() >= end_time_) stopped = true;
    return stopped;
  }
  /// Whether on_progress has asked to end the search; sets `stopped`. Polls it a few dozen times a second.
  bool is_interrupted() {
    const double now = thread_cpu_time();
    if (!on_progress_ || is_interrupted_ || now < next_poll_time_) return is_interrupted_;
    next_poll_time_ = now + 0.03;
    is_interrupted_ = !on_progress_({now - start_time_, seconds_, starts, local_searches, geometries, evaluations});
    if (!is_interrupted_) return false;
    stopped = true;
    end_time_ = std::min(end_time_, now);  // with the same grace period, so that what was found gives a design
    return true;
  }
  /// Begins a search, which lasts until finish_search.
  void begin_search() {
    deadline_.emplace(end_time_ + grace_period - thread_cpu_time(), [this] { return is_interrupted() && is_late(); });
  }
  void finish_search() { deadline_.reset(); }
  /// Whether a search has exceeded its time limit and the grace period. Evaluations then yield no value, which ends the
  /// search. Before and after a search they are not limited.
  bool is_past_deadline() {
    if (!deadline_ || !is_late()) return false;
    stopped = true;
    return true;
  }
  /// is_interrupted as a callback for another search.
  std::function<bool()> make_stop_callback() {
    return [this] { return is_interrupted(); };
  }

  bool stopped = false;  ///< a search was interrupted or ran out of time or evaluations
  int starts = 0;        ///< number of starts for solving the conditions
  int solutions = 0;     ///< number of different solutions found
  int local_searches = 0;
  int evaluations = 0;       ///< of the objective
  int geometries = 0;        ///< sets of lengths and ratios at which the other numbers were solved for
  Incumbent incumbent;       ///< the best design so far
  std::vector<double> ends;  ///< values at which independent starts ended; NaN: without a design

 private:
  static constexpr double min_remaining_time = 1e-3;
  /// Time after the end [s] that permits a first evaluation even if no time is left at the beginning.
  static constexpr double grace_period = 0.2;

  bool is_late() const { return thread_cpu_time() >= end_time_ + grace_period; }

  std::function<bool(const SearchProgress&)> on_progress_;
  double seconds_, start_time_, end_time_, next_poll_time_ = 0;
  bool is_interrupted_ = false;
  std::optional<Deadline> deadline_;  ///< during a search
};

}  // namespace balance::design
