// The controller of the scenario `uav` as a program of its own: position loop, guidance law, attitude loop (section 7.2).
// The log is, byte for byte, that of the built-in controller `hierarchical_uav`, of which this is the variant TSC.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include <phalanx.hpp>

namespace {

using Vector = std::array<double, 3>;

constexpr double gravity = 9.81;

// A slope over `hold` steps, held that long and limited. Algorithm 4, corrected.
class HeldSlope {
  public:
    HeldSlope(std::uint64_t hold, double limit, std::uint64_t delay) : hold_(hold), limit_(limit), delay_(delay) {}

    Vector update(std::uint64_t step, double dt, const Vector &input) {
        if (step <= delay_) {
            slope_ = Vector{};
            before_ = input;
        } else if (step >= taken_ * hold_) {
            const double held = static_cast<double>(hold_) * dt;
            for (int j = 0; j < 3; ++j) slope_[j] = (input[j] - before_[j]) / held;
            before_ = input;
            ++taken_;
        }
        Vector limited;
        for (int j = 0; j < 3; ++j) limited[j] = std::clamp(slope_[j], -limit_, limit_);
        return limited;
    }

  private:
    std::uint64_t hold_;
    double limit_;
    std::uint64_t delay_; // steps (after the first) without a slope yet
    std::uint64_t taken_ = 0;
    Vector before_{};
    Vector slope_{};
};

void control(phalanx::Participant &me) {
    const auto gain = [&](const char *name) { return me.number(std::string("controller.") + name); };
    const double lam_p = gain("lam_p"), c_p = gain("c_p"), k_p = gain("k_p");
    const double lam_a = gain("lam_a"), c_a = gain("c_a"), k_a = gain("k_a");
    const double gamma1 = gain("gamma1"), gamma2 = gain("gamma2"), yaw = gain("psi_d");
    const auto hold = static_cast<std::uint64_t>(gain("n_diff"));
    HeldSlope first(hold, gain("xi1_max"), 1), second(hold, gain("xi2_max"), 2);

    const double mass = me.model("m");
    const Vector effect{me.model("R") / me.model("Jx"), me.model("R") / me.model("Jy"),
                        me.model("upsilon") / me.model("Jz")}; // angular acceleration per unit of torque input

    const auto x = me.state<6>("position"), v = me.state<6>("velocity");
    const auto position = me.reference<3>("position"), velocity = me.reference<3>("velocity");
    const auto acceleration = me.reference<3>("acceleration");
    const auto estimate = me.estimate<6>("disturbance");
    const auto input = me.out<4>("input");
    const auto attitude_out = me.out<3>("attitude_reference"), xi1_out = me.out<3>("xi1"), xi2_out = me.out<3>("xi2");
    const auto sliding_position = me.out<3>("sliding_position"), sliding_attitude = me.out<3>("sliding_attitude");

    while (me.next()) {
        const double introduction = 1.0 / (1.0 + phalanx_exp(-gamma1 * (me.time() - gamma2)));

        // Position loop: the acceleration to ask for. (7.41)
        Vector push;
        for (int j = 0; j < 3; ++j) {
            const double error = x[j] - position[j], rate = v[j] - velocity[j], sliding = rate + lam_p * error;
            push[j] = acceleration[j] - introduction * estimate[j] - lam_p * rate - k_p * error - c_p * sliding;
            sliding_position[j] = sliding;
        }
        push[2] += gravity;

        // Guidance: roll and pitch that point the thrust along it. (7.31)
        const double sin_yaw = phalanx_sin(yaw), cos_yaw = phalanx_cos(yaw);
        const double length = std::sqrt(push[0] * push[0] + push[1] * push[1] + push[2] * push[2]);
        const double roll = phalanx_asin((push[0] * sin_yaw - push[1] * cos_yaw) / length);
        const double pitch = phalanx_atan((push[0] * cos_yaw + push[1] * sin_yaw) / push[2]);
        const Vector attitude{roll, pitch, yaw};
        const Vector xi1 = first.update(me.step(), me.dt(), attitude);
        const Vector xi2 = second.update(me.step(), me.dt(), xi1);

        // Attitude loop: the angular acceleration to ask for, as torques. (7.42)
        for (int j = 0; j < 3; ++j) {
            const double error = x[3 + j] - attitude[j], rate = v[3 + j] - xi1[j], sliding = rate + lam_a * error;
            const double turn = xi2[j] - introduction * estimate[3 + j] - lam_a * rate - k_a * error - c_a * sliding;
            input[1 + j] = turn / effect[j];
            attitude_out[j] = attitude[j];
            xi1_out[j] = xi1[j];
            xi2_out[j] = xi2[j];
            sliding_attitude[j] = sliding;
        }
        input[0] = mass * push[2] / (phalanx_cos(x[3]) * phalanx_cos(x[4])); // thrust (7.43)
        me.done();
    }
}

} // namespace

int main() { return phalanx::serve("controller", control); }
