#include "balance/synthesis/formulas/loop_program.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/synthesis/formulas/closed_poses.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace balance::formulas {

namespace {

constexpr int max_closing_iterations = 50;
constexpr double closing_tolerance = 1e-14, end_tolerance = 1e-9, max_correction = 0.25, min_step_fraction = 1e-4;
constexpr double final_closing_tolerance = 1e-9, redundant_row_threshold = 1e-7;

// The functions, as text. Words in capitals are replaced.

const char* const c_solve = R"(
/* Solves A x = r for `count` right-hand sides by elimination with the largest pivots, which leaves redundant rows out;
   r becomes x. Returns 1 where A is singular. */
static int solve(int rows, int unknowns, double *A, int count, double *r) {
  double largest = 0;
  for (int i = 0; i < rows * unknowns; ++i) largest = fmax(largest, fabs(A[i]));
  for (int s = 0; s < unknowns; ++s) {
    int best = s;
    for (int i = s + 1; i < rows; ++i)
      if (fabs(A[i * unknowns + s]) > fabs(A[best * unknowns + s])) best = i;
    if (!(fabs(A[best * unknowns + s]) > 1e-10 * largest)) return 1;
    for (int j = 0; j < unknowns; ++j) {
      const double other = A[s * unknowns + j];
      A[s * unknowns + j] = A[best * unknowns + j];
      A[best * unknowns + j] = other;
    }
    for (int j = 0; j < count; ++j) {
      const double other = r[s * count + j];
      r[s * count + j] = r[best * count + j];
      r[best * count + j] = other;
    }
    for (int i = s + 1; i < rows; ++i) {
      const double factor = A[i * unknowns + s] / A[s * unknowns + s];
      for (int j = s; j < unknowns; ++j) A[i * unknowns + j] -= factor * A[s * unknowns + j];
      for (int j = 0; j < count; ++j) r[i * count + j] -= factor * r[s * count + j];
    }
  }
  for (int s = unknowns - 1; s >= 0; --s)
    for (int j = 0; j < count; ++j) {
      for (int i = s + 1; i < unknowns; ++i) r[s * count + j] -= A[s * unknowns + i] * r[i * count + j];
      r[s * count + j] /= A[s * unknowns + s];
    }
  return 0;
}

/* The closures h and the columns D of their Jacobian A that belong to the dependent coordinates. */
static void dependent_columns(const double *k, const double *q, double *h, double *A, double *D) {
  closures(k, q, h, A);
  for (int i = 0; i < closure_rows; ++i)
    for (int j = 0; j < dependents; ++j) D[i * dependents + j] = A[i * coordinates + dependent[j]];
}

/* C: the rates of all coordinates per rate of the independent ones, row by row. */
static int transformation(const double *k, const double *q, double *C) {
  double h[closure_rows], A[closure_rows * coordinates], D[closure_rows * dependents], r[closure_rows * freedoms];
  dependent_columns(k, q, h, A, D);
  for (int i = 0; i < closure_rows; ++i)
    for (int u = 0; u < freedoms; ++u) r[i * freedoms + u] = -A[i * coordinates + independent[u]];
  if (solve(closure_rows, dependents, D, freedoms, r)) return SINGULAR;
  for (int i = 0; i < coordinates * freedoms; ++i) C[i] = 0;
  for (int u = 0; u < freedoms; ++u) {
    C[independent[u] * freedoms + u] = 1;
    for (int j = 0; j < dependents; ++j) C[dependent[j] * freedoms + u] = r[j * freedoms + u];
  }
  return SOLVED;
}
)";

const char* const c_close = R"(
/* Moves the dependent coordinates to where the loops close, by Newton's method. */
static int correct(const double *k, double *q) {
  double h[closure_rows], A[closure_rows * coordinates], D[closure_rows * dependents], before = HUGE_VAL;
  for (int step = 0; step < 50; ++step) {
    double change = 0, size = 1;
    dependent_columns(k, q, h, A, D);
    if (solve(closure_rows, dependents, D, 1, h)) return SINGULAR;
    for (int j = 0; j < dependents; ++j) {
      q[dependent[j]] -= h[j];
      change = fmax(change, fabs(h[j]));
      size = fmax(size, fabs(q[dependent[j]]));
    }
    if (!isfinite(change)) return NOT_CLOSED;
    if (change < 1e-14 * size || (change < 1e-9 * size && change >= before)) break;
    before = change;
  }
  closures(k, q, h, A);
  for (int i = 0; i < closure_rows; ++i)
    if (!(fabs(h[i]) <= 1e-9 * fmin(1, mechanism_length))) return NOT_CLOSED;
  return SOLVED;
}

/* Moves all coordinates q from a pose at which the loops close, or nearly, to the independent coordinates x, along a
   straight line. The steps are so short that the assembly mode stays the same. */
static int close_loops(const double *k, const double *x, double *q) {
  double from[freedoms], last[coordinates], guess[coordinates], C[coordinates * freedoms], parts = 1, done = 0, step;
  int failure = correct(k, q);
  if (failure) return failure;
  for (int u = 0; u < freedoms; ++u) {
    from[u] = q[independent[u]];
    if (!(fabs(x[u] - from[u]) <= 1e6 * max_steps[u])) return NOT_CLOSED;
    parts = fmax(parts, ceil(fabs(x[u] - from[u]) / max_steps[u]));
  }
  for (step = 1 / parts; done < 1;) {
    const double next = done + step < 1 - 1e-9 ? done + step : 1;
    double predicted = 0, corrected = 0;
    for (int i = 0; i < coordinates; ++i) last[i] = q[i];
    failure = transformation(k, q, C);
    for (int u = 0; !failure && u < freedoms; ++u) {
      const double target = next < 1 ? from[u] + (x[u] - from[u]) * next : x[u];
      for (int j = 0; j < dependents; ++j)
        q[dependent[j]] += C[dependent[j] * freedoms + u] * (target - last[independent[u]]);
      q[independent[u]] = target;
    }
    for (int i = 0; i < coordinates; ++i) guess[i] = q[i];
    if (!failure) failure = correct(k, q);
    for (int j = 0; j < dependents; ++j) {
      predicted = fmax(predicted, fabs(guess[dependent[j]] - last[dependent[j]]));
      corrected = fmax(corrected, fabs(q[dependent[j]] - guess[dependent[j]]));
    }
    if (failure || !(corrected <= 0.25 * predicted + 0.025 * fmin(1, mechanism_length))) {
      if (step * parts < 1e-4) return failure ? failure : SINGULAR;
      for (int i = 0; i < coordinates; ++i) q[i] = last[i];
      step /= 2;
    } else {
      done = next;
      step = fmin(2 * step, 1 / parts);
    }
  }
  return SOLVED;
}
)";

const char* const c_direct = R"(
  for (int a = 0; a < motors; ++a) {
    const int column = direct[a];
    u[a] = 0;
    for (int i = 0; i < coordinates; ++i) u[a] += C[i * freedoms + column] * tau[i];
  }
  return SOLVED;
)";

const char* const c_least_norm = R"(
  double S[coordinates * motors], B[freedoms * motors], N[freedoms * freedoms], w[freedoms];
  inputs(k, S);
  for (int v = 0; v < freedoms; ++v) {
    w[v] = 0;
    for (int i = 0; i < coordinates; ++i) w[v] += C[i * freedoms + v] * tau[i];
    for (int a = 0; a < motors; ++a) {
      B[v * motors + a] = 0;
      for (int i = 0; i < coordinates; ++i) B[v * motors + a] += C[i * freedoms + v] * S[i * motors + a] / force_units[a];
    }
  }
  for (int v = 0; v < freedoms; ++v)
    for (int s = 0; s < freedoms; ++s) {
      N[v * freedoms + s] = 0;
      for (int a = 0; a < motors; ++a) N[v * freedoms + s] += B[v * motors + a] * B[s * motors + a];
    }
  if (solve(freedoms, freedoms, N, 1, w)) return SINGULAR;
  for (int a = 0; a < motors; ++a) {
    u[a] = 0;
    for (int v = 0; v < freedoms; ++v) u[a] += B[v * motors + a] * w[v] / force_units[a];
  }
  return SOLVED;
)";

const char* const c_torques = R"(
/* Torques of the motors at the independent coordinates x with rates dx and accelerations ddx.
   q: before, a pose near which the loops close, such as `start` or the last one; after, that of x, or the same as before
   where they are not found. */
static int torques(const double *k, const double *x, const double *dx, const double *ddx, double *q, double *u) {
  double C[coordinates * freedoms], dq[coordinates], ddq[coordinates], h[closure_rows], A[closure_rows * coordinates];
  double D[closure_rows * dependents], b[closure_rows], pose[coordinates];
  int failure;
  for (int i = 0; i < coordinates; ++i) pose[i] = q[i];
  failure = close_loops(k, x, pose);
  if (!failure) failure = transformation(k, pose, C);
  if (failure) return failure;
  for (int i = 0; i < coordinates; ++i) {
    dq[i] = ddq[i] = 0;
    for (int v = 0; v < freedoms; ++v) {
      dq[i] += C[i * freedoms + v] * dx[v];
      ddq[i] += C[i * freedoms + v] * ddx[v];
    }
  }
  closure_bias(k, pose, dq, b);
  dependent_columns(k, pose, h, A, D);
  if (solve(closure_rows, dependents, D, 1, b)) return SINGULAR;
  for (int j = 0; j < dependents; ++j) ddq[dependent[j]] -= b[j];
  failure = motor_torques(k, pose, dq, ddq, C, u);
  for (int i = 0; !failure && i < coordinates; ++i) q[i] = pose[i];
  return failure;
}
)";

const char* const c_all_torques = R"(
/* Torques of the motors at coordinates, rates and accelerations of all joints of the tree, which must close the loops. */
static int torques(const double *k, const double *q, const double *dq, const double *ddq, double *u) {
  double C[coordinates * freedoms];
  if (transformation(k, q, C)) return SINGULAR;
  return motor_torques(k, q, dq, ddq, C, u);
}
)";

const char* const python_solve = R"(

class NotSolved(ArithmeticError):
    """The loops do not close there, or the pose is singular."""


def solve(unknowns, A, r):
    """Solves A x = r by elimination with the largest pivots, which leaves redundant rows out; r has lists of right-hand sides."""
    A, r = [list(row) for row in A], [list(row) for row in r]
    largest = max(abs(entry) for row in A for entry in row)
    for s in range(unknowns):
        best = max(range(s, len(A)), key=lambda i: abs(A[i][s]))
        if not abs(A[best][s]) > 1e-10 * largest:
            raise NotSolved("singular: the independent coordinates do not determine the motion there")
        A[s], A[best], r[s], r[best] = A[best], A[s], r[best], r[s]
        for i in range(s + 1, len(A)):
            factor = A[i][s] / A[s][s]
            A[i] = [a - factor * b for a, b in zip(A[i], A[s])]
            r[i] = [a - factor * b for a, b in zip(r[i], r[s])]
    x = [[] for _ in range(unknowns)]
    for s in reversed(range(unknowns)):
        x[s] = [(r[s][j] - sum(A[s][i] * x[i][j] for i in range(s + 1, unknowns))) / A[s][s] for j in range(len(r[s]))]
    return x


def jacobian_columns(k, q, columns):
    """The closures and columns of their Jacobian."""
    h, A = closures(k, q)
    rows = [A[i * len(q):(i + 1) * len(q)] for i in range(len(h))]
    return h, [[row[c] for c in columns] for row in rows]


def transformation(k, q):
    """C: the rates of all coordinates per rate of the independent ones."""
    _, D = jacobian_columns(k, q, DEPENDENT)
    _, R = jacobian_columns(k, q, INDEPENDENT)
    x = solve(len(DEPENDENT), D, [[-entry for entry in row] for row in R])
    C = [[0.0] * len(INDEPENDENT) for _ in q]
    for u, column in enumerate(INDEPENDENT):
        C[column][u] = 1.0
    for j, column in enumerate(DEPENDENT):
        C[column] = x[j]
    return C
)";

const char* const python_close = R"(

def correct(k, q):
    """Moves the dependent coordinates to where the loops close, by Newton's method."""
    q, before = list(q), math.inf
    for _ in range(50):
        h, D = jacobian_columns(k, q, DEPENDENT)
        change = solve(len(DEPENDENT), D, [[entry] for entry in h])
        for j, column in enumerate(DEPENDENT):
            q[column] -= change[j][0]
        step, size = max(abs(x[0]) for x in change), max(1.0, max(abs(q[column]) for column in DEPENDENT))
        if not math.isfinite(step) or step < 1e-14 * size or before <= step < 1e-9 * size:
            break
        before = step
    if not all(abs(entry) <= 1e-9 * min(1.0, LENGTH) for entry in closures(k, q)[0]):
        raise NotSolved("the loops do not close there")
    return q


def close_loops(k, x, q):
    """All coordinates at the independent ones x: from q, at which the loops close, or nearly, along a straight line. The
    steps are so short that the assembly mode stays the same."""
    q = correct(k, q)
    start = [q[column] for column in INDEPENDENT]
    if not all(abs(a - b) <= 1e6 * step for a, b, step in zip(x, start, MAX_STEPS)):
        raise NotSolved("the loops do not close there")
    parts = math.ceil(max([1.0] + [abs(a - b) / step for a, b, step in zip(x, start, MAX_STEPS)]))
    done = 0.0
    step = 1 / parts
    while done < 1:
        following = done + step if done + step < 1 - 1e-9 else 1.0
        target = [b + (a - b) * following for a, b in zip(x, start)] if following < 1 else list(x)
        try:
            change = [a - q[column] for a, column in zip(target, INDEPENDENT)]
            guess = [a + sum(b * c for b, c in zip(row, change)) for a, row in zip(q, transformation(k, q))]
            for a, column in zip(target, INDEPENDENT):
                guess[column] = a
            there = correct(k, guess)
            predicted = max(abs(guess[column] - q[column]) for column in DEPENDENT)
            corrected = max(abs(there[column] - guess[column]) for column in DEPENDENT)
            if corrected > 0.25 * predicted + 0.025 * min(1.0, LENGTH):
                raise NotSolved("singular: the loops may be closed in several ways there")
            q, done, step = there, following, min(2 * step, 1 / parts)
        except NotSolved:
            if step * parts < 1e-4:
                raise
            step /= 2
    return q
)";

const char* const python_direct = R"(
    forces = [sum(row[u] * t for row, t in zip(C, tau)) for u in range(len(INDEPENDENT))]
    return [forces[u] for u in DIRECT]
)";

const char* const python_least_norm = R"(
    motors, S = len(FORCE_UNITS), inputs(k)
    forces = [[sum(row[u] * t for row, t in zip(C, tau))] for u in range(len(INDEPENDENT))]
    B = [[sum(row[u] * S[i * motors + a] for i, row in enumerate(C)) / FORCE_UNITS[a] for a in range(motors)]
         for u in range(len(INDEPENDENT))]
    w = solve(len(B), [[sum(a * b for a, b in zip(one, other)) for other in B] for one in B], forces)
    return [sum(B[u][a] * w[u][0] for u in range(len(B))) / FORCE_UNITS[a] for a in range(motors)]
)";

const char* const python_torques = R"(

def torques(k, x, dx, ddx, q=START):
    """Torques of the motors at the independent coordinates x with rates dx and accelerations ddx, and all coordinates.

    q is a pose near which the loops close: START, or what was returned for the last x. Raises NotSolved."""
    q = close_loops(k, x, q)
    C = transformation(k, q)
    dq = [sum(a * b for a, b in zip(row, dx)) for row in C]
    ddq = [sum(a * b for a, b in zip(row, ddx)) for row in C]
    _, D = jacobian_columns(k, q, DEPENDENT)
    bias = solve(len(DEPENDENT), D, [[entry] for entry in closure_bias(k, q, dq)])
    for j, column in enumerate(DEPENDENT):
        ddq[column] -= bias[j][0]
    return motor_torques(k, q, dq, ddq, C), q
)";

const char* const python_all_torques = R"(

def torques(k, q, dq, ddq):
    """Torques of the motors at coordinates, rates and accelerations of all joints of the tree, which must close the
    loops. Raises NotSolved."""
    return motor_torques(k, q, dq, ddq, transformation(k, q))
)";

std::string join_decimals(const std::vector<double>& values) {
  std::string text;
  for (const double x : values) text += (text.empty() ? "" : ", ") + shortest_decimal(x);
  return text;
}

std::string join_indices(const std::vector<std::size_t>& values) { return fmt::format("{}", fmt::join(values, ", ")); }

std::string format_c(const LoopProgram& p) {
  const bool is_direct = !p.direct.empty();
  std::string text = "\nenum { SOLVED, NOT_CLOSED, SINGULAR }; /* what the functions below return */\n";
  text += "static const int independent[freedoms] = {" + join_indices(p.independent) + "};\n";
  text += "static const int dependent[dependents] = {" + join_indices(p.dependent) + "};\n";
  if (is_direct)
    text += "static const int direct[motors] = {" + join_indices(p.direct) + "};\n";
  else
    text += "static const double force_units[motors] = {" + join_decimals(p.force_units) + "};\n";
  if (!p.has_all_coordinates)
    text += "static const double mechanism_length = " + shortest_decimal(p.length) + ", max_steps[freedoms] = {" +
            join_decimals(p.max_steps) + "};\n" + "static const double start[coordinates] = {" +
            join_decimals(p.start) + "};\n";
  text += c_solve;
  if (!p.has_all_coordinates) text += c_close;
  text +=
      "\nstatic int motor_torques(const double *k, const double *q, const double *dq, const double *ddq, const double "
      "*C, double *u) {\n  double tau[coordinates];\n  tree_torques(k, q, dq, ddq, tau);";
  text += is_direct ? c_direct : c_least_norm;
  return text + "}\n" + (p.has_all_coordinates ? c_all_torques : c_torques);
}

std::string format_python(const LoopProgram& p) {
  const bool is_direct = !p.direct.empty();
  std::string text =
      "INDEPENDENT = [" + join_indices(p.independent) + "]\nDEPENDENT = [" + join_indices(p.dependent) + "]\n";
  text += is_direct ? "DIRECT = [" + join_indices(p.direct) + "]\n"
                    : "FORCE_UNITS = [" + join_decimals(p.force_units) + "]\n";
  if (!p.has_all_coordinates)
    text += "LENGTH = " + shortest_decimal(p.length) + "\nMAX_STEPS = [" + join_decimals(p.max_steps) + "]\nSTART = [" +
            join_decimals(p.start) + "]\n";
  text += python_solve;
  if (!p.has_all_coordinates) text += python_close;
  text += "\n\ndef motor_torques(k, q, dq, ddq, C):\n    tau = tree_torques(k, q, dq, ddq)";
  text += is_direct ? python_direct : python_least_norm;
  return text + (p.has_all_coordinates ? python_all_torques : python_torques) + "\n\n";
}

}  // namespace

std::string format_loop_functions(const LoopProgram& program, Language language) {
  return language == Language::c ? format_c(program) : format_python(program);
}

namespace {

VectorX to_vector(const std::vector<double>& x) {
  return Eigen::Map<const VectorX>(x.data(), static_cast<Eigen::Index>(x.size()));
}

VectorX least_squares(const MatrixX& A, const VectorX& r) {
  numerics::CompleteOrthogonalDecomposition solver;
  solver.setThreshold(redundant_row_threshold);
  solver.compute(A);
  return solver.solve(r);
}

}  // namespace

LoopProgramRunner::Closures LoopProgramRunner::closures(const VectorX& q) {
  const auto found = interpreter_.call("closures", {{"q", to_list(q)}},
                                       {{"h", program_.closures}, {"A", program_.closures * program_.columns}});
  Closures out{to_vector(found[0]), {}};
  out.A = Eigen::Map<const Samples>(found[1].data(), static_cast<Eigen::Index>(program_.closures),
                                    static_cast<Eigen::Index>(program_.columns));
  return out;
}

MatrixX LoopProgramRunner::dependent_columns(const MatrixX& A) const {
  MatrixX D(A.rows(), static_cast<Eigen::Index>(program_.dependent.size()));
  for (Eigen::Index j = 0; j < D.cols(); ++j)
    D.col(j) = A.col(static_cast<Eigen::Index>(program_.dependent[static_cast<std::size_t>(j)]));
  return D;
}

bool LoopProgramRunner::close_loops(VectorX& q) {
  for (int step = 0; step < max_closing_iterations; ++step) {
    const auto [h, A] = closures(q);
    const VectorX change = least_squares(dependent_columns(A), h);
    for (Eigen::Index j = 0; j < change.size(); ++j)
      q[static_cast<Eigen::Index>(program_.dependent[static_cast<std::size_t>(j)])] -= change[j];
    if (!change.allFinite()) return false;
    if (numerics::max_abs(change) < closing_tolerance) break;
  }
  return numerics::max_abs(closures(q).h) <= final_closing_tolerance * std::min(1.0, program_.length);
}

bool LoopProgramRunner::follow(const VectorX& x, VectorX& q) {
  if (!close_loops(q)) return false;
  const auto independent = [&](Eigen::Index u) {
    return static_cast<Eigen::Index>(program_.independent[static_cast<std::size_t>(u)]);
  };
  VectorX from(x.size());
  double parts = 1, done = 0;
  for (Eigen::Index u = 0; u < x.size(); ++u) {
    from[u] = q[independent(u)];
    parts = std::max(parts, std::ceil(std::abs(x[u] - from[u]) / program_.max_steps[static_cast<std::size_t>(u)]));
  }
  for (double step = 1 / parts; done < 1;) {
    const double next = done + step < 1 - end_tolerance ? done + step : 1;
    VectorX change(x.size());
    for (Eigen::Index u = 0; u < x.size(); ++u) change[u] = from[u] + (x[u] - from[u]) * next - q[independent(u)];
    const VectorX guess = q + transformation(q) * change;
    VectorX there = guess;
    const bool is_closed = close_loops(there);
    const double predicted = numerics::max_abs(guess - q), corrected = numerics::max_abs(there - guess);
    if (is_closed && corrected <= max_correction * (predicted + 0.1 * std::min(1.0, program_.length))) {
      q = there, done = next, step = std::min(2 * step, 1 / parts);
    } else {
      if (step * parts < min_step_fraction) return false;
      step /= 2;
    }
  }
  return true;
}

double LoopProgramRunner::regularity(const VectorX& q) {
  const VectorX values = numerics::singular_values(dependent_columns(closures(q).A));
  return values.size() == 0 || values[0] == 0 ? 0 : values[values.size() - 1] / values[0];
}

MatrixX LoopProgramRunner::transformation(const VectorX& q) {
  const MatrixX A = closures(q).A, D = dependent_columns(A);
  MatrixX C = MatrixX::Zero(A.cols(), static_cast<Eigen::Index>(program_.independent.size()));
  for (Eigen::Index u = 0; u < C.cols(); ++u) {
    const auto column = static_cast<Eigen::Index>(program_.independent[static_cast<std::size_t>(u)]);
    const VectorX x = least_squares(D, -A.col(column));
    C(column, u) = 1;
    for (Eigen::Index j = 0; j < x.size(); ++j)
      C(static_cast<Eigen::Index>(program_.dependent[static_cast<std::size_t>(j)]), u) = x[j];
  }
  return C;
}

LoopProgramRunner::Motion LoopProgramRunner::move(const VectorX& q, const VectorX& dx, const VectorX& ddx) {
  const MatrixX C = transformation(q);
  Motion motion{C * dx, C * ddx, {}};
  const auto b =
      interpreter_.call("closure_bias", {{"q", to_list(q)}, {"dq", to_list(motion.dq)}}, {{"b", program_.closures}});
  const VectorX bias = least_squares(dependent_columns(closures(q).A), to_vector(b[0]));
  for (Eigen::Index j = 0; j < bias.size(); ++j)
    motion.ddq[static_cast<Eigen::Index>(program_.dependent[static_cast<std::size_t>(j)])] -= bias[j];
  motion.generalised =
      C.transpose() * to_vector(interpreter_.compute_torques(to_list(q), to_list(motion.dq), to_list(motion.ddq)));
  return motion;
}

}  // namespace balance::formulas
