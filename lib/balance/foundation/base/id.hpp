#pragma once
/// Indices that cannot be taken for one another.

#include <Eigen/Core>

#include <type_traits>

namespace balance {

/// An index into a list of one kind of thing. It counts and looks up like the plain number that it is, and is made of one; from the index
/// of another kind it is neither made nor compared with it.
/// @tparam Kind any type that stands for the list, declared or not
template <class Kind>
class TypedIndex {
 public:
  constexpr TypedIndex(int index = 0)
      : index_(index) {}  // NOLINT(google-explicit-constructor): lists are counted by numbers
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

/// Entries of matrices are found by them as by numbers.
template <class Kind>
struct Eigen::internal::is_valid_index_type<balance::TypedIndex<Kind>> : std::true_type {};
