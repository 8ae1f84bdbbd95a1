/* Phalanx: programs in C, C++ and everything that can call C, in the place of a participant of a run.
 *
 *     phalanx_participant *participant = phalanx_open("controller");
 *     int position = phalanx_input(participant, "state", 0, "position", 3);
 *     int velocity = phalanx_input(participant, "state", 0, "velocity", 3);
 *     int target = phalanx_input(participant, "reference", 0, "position", 3);
 *     int input = phalanx_output(participant, 0, "input", 3);
 *     while (phalanx_next(participant)) {
 *         const double *x = phalanx_read(participant, position), *v = phalanx_read(participant, velocity);
 *         const double *r = phalanx_read(participant, target);
 *         double *u = phalanx_write(participant, input);
 *         for (int j = 0; j < 3; ++j) u[j] = 25.0 * (r[j] - x[j]) - 5.0 * v[j];
 *         phalanx_done(participant);
 *     }
 *     return phalanx_close(participant);
 *
 * and then: phalanx run triangle --swap controller.3=./my_controller
 *
 * Every function may be given NULL, and may be called at the wrong time: it then says so in phalanx_error and returns its
 * value for failure. A failure to ask for a value or a signal ends the run at the next phalanx_next, phalanx_done or
 * phalanx_close, unless phalanx_clear says that the program can do without; every other failure ends it at once. Then
 * phalanx_next returns 0, so a program without checks ends by itself, and phalanx_close returns its exit code. The run
 * reports the words of phalanx_error, and names the participant and the step. A participant is used from one thread only.
 * Agents count from 1 everywhere; 0 is the participant's own.
 */
#ifndef PHALANX_H
#define PHALANX_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Version of this interface. A library with another number of its own cannot be used with this header. */
#define PHALANX_ABI_VERSION 2

/* A participant of a run: the place that this process has been given in it. */
typedef struct phalanx_participant phalanx_participant;

/* The version of the interface that the library has. */
uint32_t phalanx_abi_version(void);

/* The place of this process in the run that started it, to serve as `role`: "plant", "planner", "observer" or "controller".
 * Never NULL: if there is no such place, phalanx_error says why, and nothing can be done but phalanx_close.
 * To be called once. */
phalanx_participant *phalanx_open(const char *role);

/* Why the first function that failed did; "" if none has since the start or phalanx_clear. Valid until the next call for the
 * same participant. */
const char *phalanx_error(const phalanx_participant *participant);

/* The program has dealt with phalanx_error: the run continues, and the next failure is the first again. Without effect once
 * the run has ended. */
void phalanx_clear(phalanx_participant *participant);

/* Ends the participant; the pointer is not valid any more. Returns the exit code for main: 0 after the last step or if
 * the run was ended from outside, 1 after an error, 2 if this process was not started by a run. */
int phalanx_close(phalanx_participant *participant);

/* ---- A process that plays several participants, as with --swap "controller.*@one=PROGRAM". ---- */

/* How many participants this process plays; 1, if the run does not say otherwise. */
int phalanx_count(const phalanx_participant *participant);
/* Makes all that follows be about the participant of this number, from 0: questions, and signals to bind. Every one is to be
 * selected before the first step. Returns 1, or 0 if no participant has this number. */
int phalanx_select(phalanx_participant *participant, int number);
/* The number of the selected participant. phalanx_next selects the one whose step it is; the participants run one after the other,
 * each with its own call of phalanx_next and phalanx_done, and only its own signals can be read and written. */
int phalanx_selected(const phalanx_participant *participant);

/* ---- What the run is. Before and between steps. ---- */

/* Number of the agent, from 1; 0 for a participant that serves several, or all of them. */
int phalanx_agent(const phalanx_participant *participant);
/* The agents that the participant serves: writes the first `capacity` of them to `agents`, ascending, and returns how many there
 * are. `agents` may be NULL if `capacity` is 0. Fails with -1. */
int phalanx_served(phalanx_participant *participant, int *agents, int capacity);
/* Number of agents in the scenario. */
int phalanx_agents(const phalanx_participant *participant);
/* Name of the participant in the run, such as "controller_3". Valid until phalanx_close. */
const char *phalanx_name(const phalanx_participant *participant);
/* Length of a step in seconds. */
double phalanx_dt(const phalanx_participant *participant);
/* Number of steps of the run. */
uint64_t phalanx_steps(const phalanx_participant *participant);

/* ---- Values of the scenario, by dotted name: "controller.c_p", "agents.2.position.1" (lists count from 1). ---- */

/* Whether the scenario as it is run, with variant, overrides and defaults, has a value of that name. */
int phalanx_has(const phalanx_participant *participant, const char *name);
/* A number as it is in force: a default if the file does not give it, the value of a formula of constants ("pi/2"), the share
 * of agent 2 in what is given for all ("topology.b.2"), a link of the default ring ("topology.A.1.3"). A boolean is 1 or 0.
 * Fails with NaN if there is no such number. */
double phalanx_number(phalanx_participant *participant, const char *name);
/* A text. Fails with NULL if there is no such text. Valid until phalanx_close. */
const char *phalanx_text(phalanx_participant *participant, const char *name);
/* Number of elements of a list. Fails with -1 if there is no such list. */
int phalanx_length(phalanx_participant *participant, const char *name);
/* The full dotted name of a parameter for programs: that of an agent (`with` in its row; 0 is the participant's own) or else
 * that of the section (`[controller.with]`), "gain" -> "controller.with.gain". phalanx_number, phalanx_text, phalanx_path and
 * phalanx_length take it. Fails with NULL if there is no such parameter. Valid until phalanx_close. */
const char *phalanx_parameter(phalanx_participant *participant, int agent, const char *name);
/* A text that is a path, meant from the folder of the scenario file: absolute. Fails with NULL. Valid until phalanx_close. */
const char *phalanx_path(phalanx_participant *participant, const char *name);
/* What a controller may know of the vehicle of an agent (from 1; 0 is the participant's own), under the name that formulas
 * use: "m", "R", "Jx", ... The nominal values, if the scenario gives such. Fails with NaN. */
double phalanx_model(phalanx_participant *participant, int agent, const char *name);

/* ---- The graph and the disturbance, as they are in force. Before and in steps; nothing is allocated. ---- */

/* Weight of the static link over which agent i receives from agent j; 0 without a link. If the graph switches (topology.at), this
 * function and those below tell the graph of the step in progress, and that of step 0 before. Fails with NaN. */
double phalanx_weight(phalanx_participant *participant, int i, int j);
/* The same while both are `distance` metres apart: where there is no static link, that of topology.proximity. */
double phalanx_weight_at(phalanx_participant *participant, int i, int j, double distance);
/* Weight of the link between an agent and the reference, topology.b. Fails with NaN. */
double phalanx_b(phalanx_participant *participant, int agent);
/* The agents from which an agent receives over static links: writes the first `capacity` of them to `agents`, ascending, and
 * returns how many there are. `agents` may be NULL if `capacity` is 0. Fails with -1. */
int phalanx_neighbours(phalanx_participant *participant, int agent, int *agents, int capacity);
/* What [disturbance] adds where the input of an agent acts, at time t, coordinates x and velocities v; x, v and out have a
 * number for each coordinate of its vehicle, and v may be NULL: zeros. Writes to `out` and returns how many numbers. Fails
 * with 0. */
int phalanx_disturbance(phalanx_participant *participant, int agent, double t, const double *x, const double *v, double *out);
/* The same for what is added to the velocities of a vehicle of order 2. */
int phalanx_mismatched(phalanx_participant *participant, int agent, double t, const double *x, const double *v, double *out);

/* ---- Signals, by name. Before the first step. ---- */

/* A signal to read: `channel` is "state" (of the plant), "reference" (of the planner), "estimate" (of the observer), all
 * of the same step, or "command" (of the controller, of the step before); `agent` counts from 1, 0 is the participant's
 * own; `length` is how many numbers are expected. Returns a handle for phalanx_read, or -1 if there is no such signal, it
 * has another length, or the participant that is replaced does not read it. */
int phalanx_input(phalanx_participant *participant, const char *channel, int agent, const char *signal, int length);
/* Any signal that the scenario lets this participant read: `role` is "plant", "planner", "observer" or "controller"; `before` is
 * 1 for the sample of the step before, 0 for that of this step; `length` 0 stands for as many numbers as the signal has. Returns
 * a handle for phalanx_read, or -1. */
int phalanx_signal(phalanx_participant *participant, const char *role, int agent, const char *signal, int length, int before);
/* How many numbers a signal has. Fails with -1 if there is no such signal. */
int phalanx_size(phalanx_participant *participant, const char *role, int agent, const char *signal);
/* A signal to write, as declared by the participant that is replaced. Returns a handle for phalanx_write, or -1. */
int phalanx_output(phalanx_participant *participant, int agent, const char *signal, int length);

/* ---- Steps. ---- */

/* Connects at the first call. Waits until this participant has to run: 1, or 0 if there is no further step, be it that the
 * run is over or that something failed. */
int phalanx_next(phalanx_participant *participant);
/* Number of the step in progress, from 0. */
uint64_t phalanx_step(const phalanx_participant *participant);
/* Simulated time at the start of the step in progress, in seconds. */
double phalanx_time(const phalanx_participant *participant);
/* The numbers of an input, where they are; valid until phalanx_done. NULL if no step is in progress. */
const double *phalanx_read(phalanx_participant *participant, int input);
/* The place for the numbers of an output; every number is to be written in every step; valid until phalanx_done. NULL if
 * no step is in progress. */
double *phalanx_write(phalanx_participant *participant, int output);
/* Checks and publishes the outputs: 1, or 0 if one is not a finite number, or no step is in progress. */
int phalanx_done(phalanx_participant *participant);
/* Ends the run with these words, because the participant cannot go on. */
void phalanx_fail(phalanx_participant *participant, const char *message);

/* ---- Mathematics: the functions that Phalanx itself uses, with the same bits on every machine. ---- */

double phalanx_sin(double x);
double phalanx_cos(double x);
double phalanx_tan(double x);
double phalanx_asin(double x);
double phalanx_acos(double x);
double phalanx_atan(double x);
double phalanx_atan2(double y, double x);
double phalanx_sinh(double x);
double phalanx_cosh(double x);
double phalanx_tanh(double x);
double phalanx_exp(double x);
double phalanx_log(double x);
double phalanx_pow(double x, double y);
double phalanx_hypot(double x, double y);

#ifdef __cplusplus
}
#endif

#endif
