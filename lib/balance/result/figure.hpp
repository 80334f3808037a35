#pragma once
/// Which number stands for a quantity over a whole run.

namespace balance {

enum class Statistic { peak, rms, mean, range };  ///< of the same names in Metric

}  // namespace balance
