#pragma once
/// Index types that cannot be confused with one another.

#include <Eigen/Core>

#include <type_traits>

namespace balance {

/// An index into one kind of list. It converts implicitly from and to a plain int, but can neither be constructed from
/// nor compared with the index of another kind of list.
/// @tparam Kind any type that identifies the list, possibly undeclared so far
template <class Kind>
class TypedIndex {
 public:
  constexpr TypedIndex(int index = 0)
      : index_(index) {}  // NOLINT(google-explicit-constructor): lists are indexed by plain numbers
  template <class Other>
  requires(!std::is_same_v<Other, Kind>) TypedIndex(TypedIndex<Other>)
  = delete;

  constexpr operator int() const { return index_; }  // NOLINT(google-explicit-constructor): as above
  constexpr TypedIndex& operator++() {
    ++index_;
    return *this;
  }
  constexpr TypedIndex& operator+=(int more) {
    index_ += more;
    return *this;
  }

 private:
  int index_;
};

template <class A, class B>
requires(!std::is_same_v<A, B>) bool operator==(TypedIndex<A>, TypedIndex<B>) = delete;
template <class A, class B>
requires(!std::is_same_v<A, B>) auto operator<=>(TypedIndex<A>, TypedIndex<B>) = delete;

}  // namespace balance

/// Lets Eigen matrices be indexed by it.
template <class Kind>
struct Eigen::internal::is_valid_index_type<balance::TypedIndex<Kind>> : std::true_type {};
