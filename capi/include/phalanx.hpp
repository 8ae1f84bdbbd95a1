// Phalanx for C++17: a thin layer over phalanx.h, which documents what everything means.
//
//     int main() {
//         return phalanx::serve("controller", [](phalanx::Participant &me) {
//             auto position = me.state<3>("position");
//             auto velocity = me.state<3>("velocity");
//             auto target = me.reference<3>("position");
//             auto input = me.out<3>("input");
//             while (me.next()) {
//                 for (int j = 0; j < 3; ++j) input[j] = 25.0 * (target[j] - position[j]) - 5.0 * velocity[j];
//                 me.done();
//             }
//         });
//     }
//
// What fails throws phalanx::Error. A program that catches it goes on; serve catches the others, and whatever else is thrown,
// and ends the run with it. Agents count from 1; 0 is the participant's own.
#ifndef PHALANX_HPP
#define PHALANX_HPP

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <stdexcept>
#include <string>
#include <vector>

#include "phalanx.h"

namespace phalanx {

// What went wrong, in words.
class Error : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

class Participant;

// A signal of N numbers to read. Its numbers stay where they are in shared steps; nothing is copied.
template <std::size_t N> class In {
  public:
    double operator[](std::size_t index) const { return data()[index]; }
    // The N numbers, valid until done().
    const double *data() const;
    static constexpr std::size_t size() { return N; }

  private:
    friend class Participant;
    In(const Participant &owner, int handle) : owner_(&owner), handle_(handle) {}
    const Participant *owner_;
    int handle_;
    // Where the numbers are, and when that was asked.
    mutable const double *numbers_ = nullptr;
    mutable std::uint64_t asked_ = 0;
};

// A signal of N numbers to write; every one of them in every step.
template <std::size_t N> class Out {
  public:
    double &operator[](std::size_t index) const { return data()[index]; }
    // The place of the N numbers, valid until done().
    double *data() const;
    static constexpr std::size_t size() { return N; }

  private:
    friend class Participant;
    Out(const Participant &owner, int handle) : owner_(&owner), handle_(handle) {}
    const Participant *owner_;
    int handle_;
    mutable double *numbers_ = nullptr;
    mutable std::uint64_t asked_ = 0;
};

// The place of this process in the run that started it. Not to be copied or moved: its signals refer to it.
class Participant {
  public:
    // Throws Error if this process was not started by a run, or by one of another version.
    explicit Participant(const char *role) : handle_(phalanx_open(role)) {
        try {
            check();
            check_version();
        } catch (...) {
            close();
            throw;
        }
    }
    ~Participant() { close(); }
    Participant(const Participant &) = delete;
    Participant &operator=(const Participant &) = delete;

    // How many participants this process plays; `select` makes what follows be about one of them, from 0, before the first step,
    // and next() selects the one whose step it is.
    int count() const { return phalanx_count(handle_); }
    void select(int number) const { checked(phalanx_select(handle_, number)); }
    int selected() const { return phalanx_selected(handle_); }

    // Number of the agent, from 1; 0 for a participant that serves several, or all of them.
    int agent() const { return phalanx_agent(handle_); }
    // The agents that it serves, ascending.
    std::vector<int> served() const {
        std::vector<int> found(static_cast<std::size_t>(checked(phalanx_served(handle_, nullptr, 0))));
        phalanx_served(handle_, found.data(), static_cast<int>(found.size()));
        return found;
    }
    // Number of agents in the scenario.
    int agents() const { return phalanx_agents(handle_); }
    // Its name in the run, such as "controller_3".
    std::string name() const { return phalanx_name(handle_); }
    // Length of a step in seconds.
    double dt() const { return phalanx_dt(handle_); }
    // Number of steps of the run.
    std::uint64_t steps() const { return phalanx_steps(handle_); }

    // Whether the scenario has a value of that name, "controller.c_p".
    bool has(const std::string &name) const { return phalanx_has(handle_, name.c_str()) != 0; }
    // A number of the scenario as it is in force: defaults and formulas of constants are resolved.
    double number(const std::string &name) const { return checked(phalanx_number(handle_, name.c_str())); }
    // A number of the scenario, or `otherwise` if it has none of that name.
    double number(const std::string &name, double otherwise) const { return has(name) ? number(name) : otherwise; }
    // A text of the scenario.
    std::string text(const std::string &name) const { return checked(phalanx_text(handle_, name.c_str())); }
    // Number of elements of a list of the scenario.
    int length(const std::string &name) const { return checked(phalanx_length(handle_, name.c_str())); }
    // A parameter of the program, [controller.with], or that of an agent (0 is its own) which overrides it.
    double parameter(const std::string &name, int agent = 0) const { return number(full_name(name, agent)); }
    // A parameter that is a text.
    std::string parameter_text(const std::string &name, int agent = 0) const { return text(full_name(name, agent)); }
    // A parameter that is a path, meant from the folder of the scenario file: absolute.
    std::string parameter_path(const std::string &name, int agent = 0) const { return path(full_name(name, agent)); }
    // A text of the scenario that is a path, by its dotted name.
    std::string path(const std::string &name) const { return checked(phalanx_path(handle_, name.c_str())); }
    // A number of the nominal model of an agent's vehicle, "m".
    double model(const std::string &name, int agent = 0) const {
        return checked(phalanx_model(handle_, agent, name.c_str()));
    }

    // Weight of the static link over which agent i receives from agent j; 0 if there is none.
    double weight(int i, int j) const { return checked(phalanx_weight(handle_, i, j)); }
    // The same while both are `distance` metres apart: where there is no static link, that of topology.proximity.
    double weight(int i, int j, double distance) const { return checked(phalanx_weight_at(handle_, i, j, distance)); }
    // Weight of the link between an agent and the reference.
    double b(int agent = 0) const { return checked(phalanx_b(handle_, agent)); }
    // The agents from which an agent receives over static links, ascending.
    std::vector<int> neighbours(int agent = 0) const {
        std::vector<int> found(static_cast<std::size_t>(checked(phalanx_neighbours(handle_, agent, nullptr, 0))));
        phalanx_neighbours(handle_, agent, found.data(), static_cast<int>(found.size()));
        return found;
    }
    // What [disturbance] adds where the input of an agent acts, at time t, coordinates x and velocities v (nullptr: zeros).
    // All have a number for each coordinate of its vehicle.
    void disturbance(int agent, double t, const double *x, const double *v, double *out) const {
        phalanx_disturbance(handle_, agent, t, x, v, out);
        check();
    }
    // The same for what is added to the velocities of a vehicle of order 2.
    void mismatched(int agent, double t, const double *x, const double *v, double *out) const {
        phalanx_mismatched(handle_, agent, t, x, v, out);
        check();
    }

    // A signal of the plant, of this step; `agent` counts from 1, 0 is the participant's own.
    template <std::size_t N> In<N> state(const char *signal, int agent = 0) const {
        return input<N>("state", signal, agent);
    }
    // A signal of the planner, of this step.
    template <std::size_t N> In<N> reference(const char *signal, int agent = 0) const {
        return input<N>("reference", signal, agent);
    }
    // A signal of an observer, of this step.
    template <std::size_t N> In<N> estimate(const char *signal, int agent = 0) const {
        return input<N>("estimate", signal, agent);
    }
    // A signal of a controller, of the step before.
    template <std::size_t N> In<N> command_before(const char *signal, int agent = 0) const {
        return input<N>("command", signal, agent);
    }
    // Any signal that the scenario lets this participant read: of a "plant", "planner", "observer" or "controller", of this
    // step or of the step before.
    template <std::size_t N> In<N> read(const char *role, const char *signal, int agent = 0, bool before = false) const {
        return In<N>(*this, checked(phalanx_signal(handle_, role, agent, signal, static_cast<int>(N), before ? 1 : 0)));
    }
    // How many numbers a signal has.
    int size(const char *role, const char *signal, int agent = 0) const {
        return checked(phalanx_size(handle_, role, agent, signal));
    }
    // A signal that this participant publishes.
    template <std::size_t N> Out<N> out(const char *signal, int agent = 0) const {
        return Out<N>(*this, checked(phalanx_output(handle_, agent, signal, static_cast<int>(N))));
    }

    // Waits for the next step; false after the last one.
    bool next() {
        ++moves_;
        if (phalanx_next(handle_) != 0) return true;
        check();
        return false;
    }
    // Number of the step in progress, from 0.
    std::uint64_t step() const { return phalanx_step(handle_); }
    // Simulated time at its start, in seconds.
    double time() const { return phalanx_time(handle_); }
    // Publishes the outputs.
    void done() {
        ++moves_;
        if (phalanx_done(handle_) == 0) check();
    }
    // Ends the run with these words.
    [[noreturn]] void fail(const std::string &message) const {
        phalanx_fail(handle_, message.c_str());
        throw Error(message);
    }

    // Leaves the run; returns the exit code for main. Nothing but the destructor may follow.
    int close() {
        phalanx_participant *handle = handle_;
        handle_ = nullptr;
        return handle == nullptr ? 0 : phalanx_close(handle);
    }
    // The participant as phalanx.h knows it.
    phalanx_participant *handle() const { return handle_; }

  private:
    template <std::size_t> friend class In;
    template <std::size_t> friend class Out;

    std::string full_name(const std::string &name, int agent) const {
        return checked(phalanx_parameter(handle_, agent, name.c_str()));
    }
    template <std::size_t N> In<N> input(const char *channel, const char *signal, int agent) const {
        return In<N>(*this, checked(phalanx_input(handle_, channel, agent, signal, static_cast<int>(N))));
    }
    template <class Value> Value checked(Value value) const {
        check();
        return value;
    }
    // Throws what went wrong; it is the caller's then, and the library forgets it.
    void check() const {
        const std::string error = phalanx_error(handle_);
        if (error.empty()) return;
        phalanx_clear(handle_);
        throw Error(error);
    }

    void check_version() const {
        const auto library = phalanx_abi_version();
        if (library == PHALANX_ABI_VERSION) return;
        fail("the library phalanx has version " + std::to_string(library) +
             " of its interface, but this program was compiled for version " + std::to_string(PHALANX_ABI_VERSION));
    }

    phalanx_participant *handle_;
    // How often a step has begun or ended: pointers of before are not valid any more.
    std::uint64_t moves_ = 1;
};

template <std::size_t N> const double *In<N>::data() const {
    if (asked_ != owner_->moves_) {
        numbers_ = phalanx_read(owner_->handle_, handle_);
        if (numbers_ == nullptr) owner_->check();
        asked_ = owner_->moves_;
    }
    return numbers_;
}

template <std::size_t N> double *Out<N>::data() const {
    if (asked_ != owner_->moves_) {
        numbers_ = phalanx_write(owner_->handle_, handle_);
        if (numbers_ == nullptr) owner_->check();
        asked_ = owner_->moves_;
    }
    return numbers_;
}

// The whole main of a program: opens the participant, does `work` with it, and tells the run if that throws.
template <class Work> int serve(const char *role, Work work) {
    try {
        Participant me(role);
        try {
            work(me);
        } catch (const Error &error) {
            std::fprintf(stderr, "%s\n", error.what());
            phalanx_fail(me.handle(), error.what());
        } catch (const std::exception &exception) {
            phalanx_fail(me.handle(), exception.what());
        } catch (...) {
            phalanx_fail(me.handle(), "something was thrown that is no std::exception");
        }
        return me.close();
    } catch (const Error &error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 2;
    }
}

} // namespace phalanx

#endif
