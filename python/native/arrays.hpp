#pragma once
/// Numbers of the library as NumPy's arrays.

#include "balance/foundation/base/types.hpp"

#include <pybind11/numpy.h>

#include <memory>
#include <utility>
#include <vector>

namespace balance::python {

namespace py = pybind11;

/// What callers give: rows of numbers one behind the other, copied only if they are not so already.
using Numbers = py::array_t<double, py::array::c_style | py::array::forcecast>;

/// The same memory, which nobody can write to; `owner` lives as long as the array does.
template <class T>
py::array read_only(const T* data, std::vector<py::ssize_t> shape, py::handle owner) {
  py::array_t<T> array(std::move(shape), data, owner);
  py::detail::array_proxy(array.ptr())->flags &= ~py::detail::npy_api::NPY_ARRAY_WRITEABLE_;
  return array;
}

/// A matrix moves into an array, without a copy of its numbers.
inline py::array owned(Samples&& numbers) {
  auto kept = std::make_unique<Samples>(std::move(numbers));
  const Samples& matrix = *kept;
  const py::capsule owner(kept.release(), [](void* p) { delete static_cast<Samples*>(p); });
  return py::array_t<double>({matrix.rows(), matrix.cols()}, matrix.data(), owner);
}

inline py::array copied(const VectorX& numbers) { return py::array_t<double>(numbers.size(), numbers.data()); }

inline Eigen::Map<const Samples> rows_of(const Numbers& array) {
  return {array.data(), array.shape(0), array.shape(1)};
}

inline VectorX vector_of(const Numbers& array) {
  return Eigen::Map<const VectorX>(array.data(), static_cast<Eigen::Index>(array.size()));
}

}  // namespace balance::python
