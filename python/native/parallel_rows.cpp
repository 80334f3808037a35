#include "parallel_rows.hpp"

#include <algorithm>
#include <cmath>
#include <exception>
#include <numbers>
#include <optional>
#include <thread>

namespace balance::python {
namespace {

constexpr Eigen::Index rows_per_poll = 8192;       // between two looks whether somebody still waits
constexpr Eigen::Index min_rows_per_thread = 512;  // a thread is not worth less

class RowRange {
 public:
  RowRange(const Mechanism& mechanism, const InverseOptions& options, const EffortRequest& question, Eigen::Index begin,
           Eigen::Index end)
      : mechanism_(mechanism), question_(question), begin_(begin), end_(end), door_(mechanism, options) {}

  /// Whether the mechanism has loops and this is not the first part: then it matters how its first state was reached.
  void note_first_state() { first_ = state(begin_); }

  void run(Samples& efforts, const std::function<bool()>& is_stopped) {
    failures_.clear();
    for (Eigen::Index at = begin_; at < end_ && !is_stopped(); at += rows_per_poll) {
      const Eigen::Index count = std::min(rows_per_poll, end_ - at);
      const VectorX time = question_.time.size() == 0 ? VectorX() : VectorX(question_.time.segment(at, count));
      EffortBatch answers = door_.effort_rows(question_.q.middleRows(at, count), question_.dq.middleRows(at, count),
                                              question_.ddq.middleRows(at, count), time);
      efforts.middleRows(at, count) = answers.efforts;
      for (FailedRow& one : answers.failures) failures_.push_back({one.row + at, std::move(one.outcome)});
    }
  }

  /// Whether the part before, going on, comes to this part's first state as this part did.
  bool follows(RowRange& before) {
    const std::optional<VectorX> reached = before.state(begin_);
    return first_ && reached && is_same(*first_, *reached);
  }

  void go_on_from(RowRange& before) { door_ = std::move(before.door_); }

  std::vector<FailedRow> take_failures() { return std::move(failures_); }

 private:
  std::optional<VectorX> state(Eigen::Index row) {
    const auto found = door_.at(question_.q.row(row), question_.dq.row(row), question_.ddq.row(row),
                                question_.time.size() == 0 ? 0 : question_.time[row]);
    return found ? std::optional(found.value.position) : std::nullopt;
  }

  /// Newton's iteration leaves 1e-12; modes are as far apart as the mechanism is large.
  bool is_same(const VectorX& a, const VectorX& b) const {
    constexpr double same_mode_tolerance = 1e-6;
    const double length = characteristic_length(mechanism_);
    for (std::size_t i = 0; i < mechanism_.coordinates.size(); ++i) {
      const double apart = a[static_cast<Eigen::Index>(i)] - b[static_cast<Eigen::Index>(i)];
      const bool angle = mechanism_.coordinates[i].kind == CoordinateKind::angle;
      if (std::abs(angle ? std::remainder(apart, 2 * std::numbers::pi) : apart / length) > same_mode_tolerance)
        return false;
    }
    return true;
  }

  const Mechanism& mechanism_;
  const EffortRequest& question_;
  Eigen::Index begin_, end_;
  InverseDynamics door_;
  std::optional<VectorX> first_;
  std::vector<FailedRow> failures_;
};

/// Runs the parts side by side, the first one here.
void run_all(std::vector<RowRange>& parts, bool loops, Samples& efforts, const std::function<bool()>& is_stopped) {
  std::vector<std::exception_ptr> troubles(parts.size());
  const auto run = [&](std::size_t k) {
    try {
      if (loops && k > 0) parts[k].note_first_state();
      parts[k].run(efforts, is_stopped);
    } catch (...) {
      troubles[k] = std::current_exception();
    }
  };
  {
    std::vector<std::jthread> threads;
    for (std::size_t k = 1; k < parts.size(); ++k) threads.emplace_back(run, k);
    run(0);
  }
  for (const std::exception_ptr& trouble : troubles)
    if (trouble) std::rethrow_exception(trouble);
}

}  // namespace

EffortBatch effort_rows(const Mechanism& mechanism, const InverseOptions& options, const EffortRequest& question,
                        unsigned threads, const std::function<bool()>& is_stopped) {
  const Eigen::Index rows = question.q.rows();
  const Eigen::Index count = std::clamp<Eigen::Index>(rows / min_rows_per_thread, 1, std::max(1U, threads));
  if (question.dq.rows() != rows || question.ddq.rows() != rows || (count == 1 && rows <= rows_per_poll))
    return InverseDynamics(mechanism, options).effort_rows(question.q, question.dq, question.ddq, question.time);
  const bool loops = mechanism.joints.size() + 1 > mechanism.bodies.size();
  std::vector<RowRange> parts;
  parts.reserve(static_cast<std::size_t>(count));
  for (Eigen::Index k = 0; k < count; ++k)
    parts.emplace_back(mechanism, options, question, rows * k / count, rows * (k + 1) / count);
  EffortBatch all;
  all.efforts.resize(rows, static_cast<Eigen::Index>(mechanism.actuators.size()));
  run_all(parts, loops, all.efforts, is_stopped);
  for (std::size_t k = 0; k < parts.size(); ++k) {
    if (loops && k > 0 && !parts[k].follows(parts[k - 1])) {
      parts[k].go_on_from(parts[k - 1]);
      parts[k].run(all.efforts, is_stopped);
    }
    for (FailedRow& one : parts[k].take_failures()) all.failures.push_back(std::move(one));
  }
  return all;
}

}  // namespace balance::python
