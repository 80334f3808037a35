#pragma once
/// Collects the faults of a mechanism while it is looked through. Private to model.

#include "balance/model/inertia_rule.hpp"
#include "balance/model/validate.hpp"

#include <cmath>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace balance {

/// "body 'crank'", or "body 2" where it has no name.
std::string text_of(ElementKind element, std::size_t index, std::string_view name);

/// Short, and long enough to tell 1 from 1.0000001.
std::string text_of(double number);

/// One element's faults.
class ElementFaults {
 public:
  ElementFaults(ElementKind element, std::size_t index, std::string_view name, std::vector<Fault>& all)
      : element_(element), index_(static_cast<int>(index)), who_(text_of(element, index, name)), all_(all) {}

  void add(FaultKind kind, const std::string& what) { all_.push_back({kind, element_, index_, who_ + ": " + what}); }

  /// @return whether it is finite
  bool finite(double number, const char* what) {
    if (!std::isfinite(number))
      add(FaultKind::not_finite, std::string(what) + " must be finite, is " + text_of(number));
    return std::isfinite(number);
  }
  template <class Derived>
  bool finite(const Eigen::MatrixBase<Derived>& numbers, const char* what) {
    const bool good = numbers.allFinite();
    if (!good) add(FaultKind::not_finite, std::string(what) + " must consist of finite numbers");
    return good;
  }

  void not_negative(double number, const char* what) {
    if (finite(number, what) && number < 0)
      add(FaultKind::negative_number, std::string(what) + " must not be negative, is " + text_of(number));
  }

  /// @return whether `index` is one of `count`
  bool in_range(int index, std::size_t count, const char* what) {
    const bool good = index >= 0 && static_cast<std::size_t>(index) < count;
    if (!good)
      add(FaultKind::index_out_of_range,
          std::string(what) + " must be one of " + std::to_string(count) + " (from 0), is " + std::to_string(index));
    return good;
  }

  void unit(const Vector3& axis, const char* what);
  /// A place in the plane of a planar mechanism.
  void place(const Vector3& position, bool planar, const char* what);

 private:
  ElementKind element_;
  int index_;
  std::string who_;
  std::vector<Fault>& all_;
};

void check_inertia(const Matrix3& inertia, bool planar, InertiaOf bearer, ElementFaults& faults);

/// @param what "the coordinate that leads" @return whether all that is followed are coordinates
bool check_followed(const Followed& followed, std::size_t coordinates, const char* what, ElementFaults& faults);

// The parts of validate().
void check_bodies(const Mechanism& mechanism, std::vector<Fault>& all);
void check_joints(const Mechanism& mechanism, std::vector<Fault>& all);
void check_constraints(const Mechanism& mechanism, std::vector<Fault>& all);
void check_attachments(const Mechanism& mechanism, std::vector<Fault>& all);
void check_discs(const Mechanism& mechanism, std::vector<Fault>& all);
void check_loads(const Mechanism& mechanism, std::vector<Fault>& all);
void check_springs(const Mechanism& mechanism, std::vector<Fault>& all);
void check_friction(const Mechanism& mechanism, std::vector<Fault>& all);

}  // namespace balance
