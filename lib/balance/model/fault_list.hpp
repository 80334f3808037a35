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
std::string format_element(ElementKind element, std::size_t index, std::string_view name);

/// Short, and long enough to tell 1 from 1.0000001.
std::string format_element(double number);

/// One element's faults.
class ElementValidator {
 public:
  ElementValidator(ElementKind element, std::size_t index, std::string_view name, std::vector<ValidationIssue>& all)
      : element_(element), index_(static_cast<int>(index)), who_(format_element(element, index, name)), all_(all) {}

  void add(ValidationIssueKind kind, const std::string& what) {
    all_.push_back({kind, element_, index_, who_ + ": " + what});
  }

  /// @return whether it is finite
  bool check_finite(double number, const char* what) {
    if (!std::isfinite(number))
      add(ValidationIssueKind::not_finite, std::string(what) + " must be finite, is " + format_element(number));
    return std::isfinite(number);
  }
  template <class Derived>
  bool check_finite(const Eigen::MatrixBase<Derived>& numbers, const char* what) {
    const bool good = numbers.allFinite();
    if (!good) add(ValidationIssueKind::not_finite, std::string(what) + " must consist of finite numbers");
    return good;
  }

  void check_not_negative(double number, const char* what) {
    if (check_finite(number, what) && number < 0)
      add(ValidationIssueKind::negative_number,
          std::string(what) + " must not be negative, is " + format_element(number));
  }

  /// @return whether `index` is one of `count`
  bool check_index(int index, std::size_t count, const char* what) {
    const bool good = index >= 0 && static_cast<std::size_t>(index) < count;
    if (!good)
      add(ValidationIssueKind::index_out_of_range,
          std::string(what) + " must be one of " + std::to_string(count) + " (from 0), is " + std::to_string(index));
    return good;
  }

  void check_unit_vector(const Vector3& axis, const char* what);
  /// A place in the plane of a planar mechanism.
  void check_position(const Vector3& position, bool planar, const char* what);

 private:
  ElementKind element_;
  int index_;
  std::string who_;
  std::vector<ValidationIssue>& all_;
};

void check_inertia(const Matrix3& inertia, bool planar, InertiaOwner bearer, ElementValidator& faults);

/// @param what "the coordinate that leads" @return whether all that is followed are coordinates
bool check_followed(const CoordinateCombination& followed, std::size_t coordinates, const char* what,
                    ElementValidator& faults);

// The parts of validate().
void check_bodies(const Mechanism& mechanism, std::vector<ValidationIssue>& all);
void check_joints(const Mechanism& mechanism, std::vector<ValidationIssue>& all);
void check_constraints(const Mechanism& mechanism, std::vector<ValidationIssue>& all);
void check_attachments(const Mechanism& mechanism, std::vector<ValidationIssue>& all);
void check_discs(const Mechanism& mechanism, std::vector<ValidationIssue>& all);
void check_loads(const Mechanism& mechanism, std::vector<ValidationIssue>& all);
void check_springs(const Mechanism& mechanism, std::vector<ValidationIssue>& all);
void check_friction(const Mechanism& mechanism, std::vector<ValidationIssue>& all);

}  // namespace balance
