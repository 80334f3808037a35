#pragma once
/// What a design may spend, and what it has done with it.

#include "balance/foundation/base/cpu_time.hpp"
#include "balance/synthesis/design/design_problem.hpp"

#include <algorithm>
#include <functional>
#include <optional>
#include <utility>

namespace balance::design {

class SearchBudget {
 public:
  /// @param watch as DesignProblem::watch
  explicit SearchBudget(double seconds, std::function<bool(const SearchProgress&)> watch = {})
      : watch_(std::move(watch)), begin_(thread_cpu_time()), end_(begin_ + seconds) {}

  /// [s], positive.
  double remaining_time() const {
    return interrupted_ ? min_remaining_time : std::max(min_remaining_time, end_ - thread_cpu_time());
  }
  /// Nothing is left; remembered.
  bool is_spent() {
    if (is_interrupted() || thread_cpu_time() >= end_) stopped = true;
    return stopped;
  }
  /// Whoever watches wants the end; remembered. Asks a few dozen times a second.
  bool is_interrupted() {
    const double now = thread_cpu_time();
    if (!watch_ || interrupted_ || now < next_) return interrupted_;
    next_ = now + 0.03;
    interrupted_ = !watch_({now - begin_, end_ - begin_, starts, local_searches, geometries, evaluations});
    stopped = stopped || interrupted_;
    return interrupted_;
  }
  /// From here on it is searched, until finish().
  void begin_search() {
    deadline_.emplace(end_ + grace_period - thread_cpu_time(), [this] { return is_interrupted(); });
  }
  void finish_search() { deadline_.reset(); }
  /// What is searched for now comes too late: evaluations give nothing, so that searches end. Before and after a search
  /// they take what they take.
  bool is_past_deadline() {
    const bool late = deadline_ && (interrupted_ || thread_cpu_time() >= end_ + grace_period);
    stopped = stopped || late;
    return late;
  }
  /// For searches that ask others.
  std::function<bool()> make_stop_callback() {
    return [this] { return is_interrupted(); };
  }

  bool stopped = false;     ///< a search ended for lack of time or evaluations, or was interrupted
  int starts = 0;           ///< from which conditions were solved
  int solutions = 0;        ///< different ones found
  int local_searches = 0;   ///< local searches
  int evaluations = 0;      ///< of the objective in searches
  int repeated_optima = 0;  ///< of the local searches over lengths: ended as well as the best one
  int geometries = 0;       ///< lengths and ratios at which the other numbers were solved for

 private:
  static constexpr double min_remaining_time = 1e-3;
  /// After the end [s]: where nothing is left to begin with, there is still a first look.
  static constexpr double grace_period = 0.2;

  std::function<bool(const SearchProgress&)> watch_;
  double begin_, end_, next_ = 0;
  bool interrupted_ = false;
  std::optional<Deadline> deadline_;  ///< while it is searched
};

}  // namespace balance::design
