#pragma once
/// What a design may spend, and what it has done with it. Private to design.

#include "balance/base/computing_time.hpp"
#include "balance/design/problem.hpp"

#include <algorithm>
#include <functional>
#include <optional>
#include <utility>

namespace balance::designing {

class Budget {
 public:
  /// @param watch as DesignProblem::watch
  explicit Budget(double seconds, std::function<bool(const SearchProgress&)> watch = {})
      : watch_(std::move(watch)), begin_(computing_time()), end_(begin_ + seconds) {}

  /// [s], positive.
  double left() const { return interrupted_ ? least : std::max(least, end_ - computing_time()); }
  /// Nothing is left; remembered.
  bool spent() {
    if (interrupted() || computing_time() >= end_) stopped = true;
    return stopped;
  }
  /// Whoever watches wants the end; remembered. Asks a few dozen times a second.
  bool interrupted() {
    const double now = computing_time();
    if (!watch_ || interrupted_ || now < next_) return interrupted_;
    next_ = now + 0.03;
    interrupted_ = !watch_({now - begin_, end_ - begin_, starts, descents, geometries, evaluations});
    stopped = stopped || interrupted_;
    return interrupted_;
  }
  /// From here on it is searched, until finish().
  void begin_search() {
    deadline_.emplace(end_ + grace - computing_time(), [this] { return interrupted(); });
  }
  void finish_search() { deadline_.reset(); }
  /// What is searched for now comes too late: evaluations give nothing, so that searches end. Before and after a search
  /// they take what they take.
  bool over() {
    const bool late = deadline_ && (interrupted_ || computing_time() >= end_ + grace);
    stopped = stopped || late;
    return late;
  }
  /// For searches that ask others.
  std::function<bool()> stopper() {
    return [this] { return interrupted(); };
  }

  bool stopped = false;  ///< a search ended for lack of time or evaluations, or was interrupted
  int starts = 0;        ///< from which conditions were solved
  int solutions = 0;     ///< different ones found
  int descents = 0;      ///< local searches
  int evaluations = 0;   ///< of the objective in searches
  int alike = 0;         ///< of the local searches over lengths: ended as well as the best one
  int geometries = 0;    ///< lengths and ratios at which the other numbers were solved for

 private:
  static constexpr double least = 1e-3;
  /// After the end [s]: where nothing is left to begin with, there is still a first look.
  static constexpr double grace = 0.2;

  std::function<bool(const SearchProgress&)> watch_;
  double begin_, end_, next_ = 0;
  bool interrupted_ = false;
  std::optional<Deadline> deadline_;  ///< while it is searched
};

}  // namespace balance::designing
