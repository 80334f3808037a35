#include "balance/expression/graph.hpp"

#include "balance/base/elementary.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace balance {

namespace {

double sign(double x) { return x < 0 ? -1 : x > 0 ? 1 : 0; }
double none(double /*x*/) { return 0; }

constexpr std::array functions{
    UnaryFunction{"sin", [](double x) { return elementary::sin(x); }, [](double x) { return elementary::cos(x); }},
    UnaryFunction{"cos", [](double x) { return elementary::cos(x); }, [](double x) { return -elementary::sin(x); }},
    UnaryFunction{"tan", [](double x) { return elementary::tan(x); },
                  [](double x) { return 1 + elementary::tan(x) * elementary::tan(x); }},
    UnaryFunction{"asin", [](double x) { return elementary::asin(x); },
                  [](double x) { return 1 / std::sqrt(1 - x * x); }},
    UnaryFunction{"acos", [](double x) { return elementary::acos(x); },
                  [](double x) { return -1 / std::sqrt(1 - x * x); }},
    UnaryFunction{"atan", [](double x) { return elementary::atan(x); }, [](double x) { return 1 / (1 + x * x); }},
    UnaryFunction{"sinh", [](double x) { return elementary::sinh(x); }, [](double x) { return elementary::cosh(x); }},
    UnaryFunction{"cosh", [](double x) { return elementary::cosh(x); }, [](double x) { return elementary::sinh(x); }},
    UnaryFunction{"tanh", [](double x) { return elementary::tanh(x); },
                  [](double x) { return 1 - elementary::tanh(x) * elementary::tanh(x); }},
    UnaryFunction{"asinh", [](double x) { return elementary::asinh(x); },
                  [](double x) { return 1 / std::sqrt(x * x + 1); }},
    UnaryFunction{"acosh", [](double x) { return elementary::acosh(x); },
                  [](double x) { return 1 / std::sqrt(x * x - 1); }},
    UnaryFunction{"atanh", [](double x) { return elementary::atanh(x); }, [](double x) { return 1 / (1 - x * x); }},
    UnaryFunction{"sqrt", [](double x) { return std::sqrt(x); },
                  // of zero that of zero, as for all other scalars of this program
                  [](double x) { return x == 0 ? 0 : 0.5 / std::sqrt(x); }},
    UnaryFunction{"exp", [](double x) { return elementary::exp(x); }, [](double x) { return elementary::exp(x); }},
    UnaryFunction{"ln", [](double x) { return elementary::log(x); }, [](double x) { return 1 / x; }},
    UnaryFunction{"log10", [](double x) { return elementary::log10(x); },
                  [](double x) { return 1 / (x * std::numbers::ln10); }},
    UnaryFunction{"log2", [](double x) { return elementary::log2(x); },
                  [](double x) { return 1 / (x * std::numbers::ln2); }},
    UnaryFunction{"abs", [](double x) { return x >= 0 ? x : -x; }, sign},
    UnaryFunction{"sign", sign, none},
    UnaryFunction{"rint", [](double x) { return std::floor(x + 0.5); }, none},
};

}  // namespace

std::span<const UnaryFunction> list_unary_functions() { return functions; }

int find_unary_function(std::string_view name) {
  const auto found =
      std::find_if(functions.begin(), functions.end(), [&](const UnaryFunction& f) { return f.name == name; });
  return static_cast<int>(found - functions.begin());
}

}  // namespace balance
