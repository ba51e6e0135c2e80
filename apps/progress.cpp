#include "progress.hpp"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>

#include "commands.hpp"

namespace matpoint {
namespace {

constexpr std::chrono::milliseconds k_interval{200};
constexpr int k_bar_width = 24;

std::size_t terminal_width() {
  winsize size{};
  return ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 80;
}

}  // namespace

Progress::Progress(const Case& problem)
    : end_(problem.time.end), is_terminal_(isatty(STDOUT_FILENO) == 1), start_(Clock::now()), last_print_(start_) {}

double Progress::seconds() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }

void Progress::update(const Simulation& simulation) {
  if (simulation.step_count() > step_) {
    step_ = simulation.step_count();
    for (std::size_t b = 0; b < simulation.solver().body_count(); ++b)
      updates_ += static_cast<double>(simulation.solver().particle_count(b));
  }
  const double fraction = end_ > 0 ? std::clamp(simulation.time() / end_, 0.0, 1.0) : 0;
  if (is_terminal_) {
    const Clock::time_point now = Clock::now();
    if (now - last_print_ < k_interval) return;
    last_print_ = now;
    print_bar(simulation, fraction);
  } else if (const int tenths = static_cast<int>(fraction * 10 + 1e-9); tenths > tenths_ && tenths < 10) {
    tenths_ = tenths;
    say("{:3d} %  {}\n", tenths * 10, status(simulation, fraction));
    std::fflush(stdout);
  }
}

std::string Progress::status(const Simulation& simulation, double fraction) const {
  const double elapsed = seconds();
  const double left = fraction > 0 ? elapsed * (1 - fraction) / fraction : std::numeric_limits<double>::infinity();
  return fmt::format("t = {:.4g} s  step {}  {} particle-updates/s  {} left", simulation.time(), simulation.step_count(),
                     count_text(elapsed > 0 ? updates_ / elapsed : 0), duration_text(left));
}

void Progress::print_bar(const Simulation& simulation, double fraction) {
  const int filled = static_cast<int>(fraction * k_bar_width);
  std::string line =
      fmt::format("[{}{}] {:5.1f} %  {}", std::string(static_cast<std::size_t>(filled), '#'),
                  std::string(static_cast<std::size_t>(k_bar_width - filled), '.'), 100 * fraction, status(simulation, fraction));
  // A line that wraps could not be replaced by the next one.
  line.resize(std::min(line.size(), terminal_width() - 1));
  say("\r{}\x1b[K", line);
  std::fflush(stdout);
  has_line_ = true;
}

void Progress::clear() {
  if (!has_line_) return;
  say("\r\x1b[K");
  std::fflush(stdout);
  has_line_ = false;
}

}  // namespace matpoint
