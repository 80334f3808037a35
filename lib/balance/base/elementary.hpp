#pragma once
/// Elementary functions that give the same bits on every machine: those of the system's library choose by the processor whether products
/// are fused with sums, and their last digits with it. IEEE 754 fixes the basic operations, roots, rounding and remainders; for all
/// else the library calls these. Arguments that have no value (the logarithm of a negative number) give not-a-number.

#include "balance/base/sine.hpp"

namespace balance {

/// A namespace of their own: a program that says `using namespace balance` keeps its `sin`.
namespace elementary {

inline double sin(double x) { return sine_cosine(x).sine; }
inline double cos(double x) { return sine_cosine(x).cosine; }

// Error below 2 units in the last place.
double tan(double x);
double asin(double x);
double acos(double x);
double atan(double x);
double atan2(double y, double x);

// Found with twice the digits and rounded: some microseconds each.
double sinh(double x);
double cosh(double x);
double tanh(double x);
double asinh(double x);
double acosh(double x);
double atanh(double x);
double exp(double x);
double log(double x);
double log10(double x);
double log2(double x);
double log1p(double x);
double pow(double x, double y);

}  // namespace elementary

/// Under the name that the recursions call.
inline void sine_cosine_into(double x, double& sine, double& cosine) {
  const auto both = sine_cosine(x);
  sine = both.sine, cosine = both.cosine;
}

}  // namespace balance
