/* A controller of the scenario `uav` that makes one mistake, the one that its argument names, at step 7 or before. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include <phalanx.h>

static const char *mistake;

static int is(const char *name) { return strcmp(mistake, name) == 0; }

int main(int count, char **arguments)
{
    static const char *const names[] = {"attitude_reference", "xi1", "xi2", "sliding_position", "sliding_attitude"};
    phalanx_participant *me;
    int state, input, others[5], k;
    mistake = count > 1 ? arguments[1] : "";
    if (is("null")) {
        /* Each of them says no, and none of them crashes. */
        int wrong = phalanx_next(NULL) + phalanx_done(NULL) + phalanx_agent(NULL) + phalanx_agents(NULL) +
                    (phalanx_read(NULL, 0) != NULL) + (phalanx_write(NULL, 0) != NULL) + phalanx_has(NULL, "x") +
                    (phalanx_input(NULL, NULL, 0, NULL, 0) != -1) + (phalanx_output(NULL, 0, NULL, 0) != -1) +
                    !isnan(phalanx_number(NULL, NULL)) + (phalanx_text(NULL, NULL) != NULL) +
                    !isnan(phalanx_weight(NULL, 1, 2)) + !isnan(phalanx_weight_at(NULL, 1, 2, 0.5)) + !isnan(phalanx_b(NULL, 1)) +
                    (phalanx_neighbours(NULL, 1, NULL, 0) != -1) + phalanx_disturbance(NULL, 1, 0.0, NULL, NULL, NULL) +
                    phalanx_mismatched(NULL, 1, 0.0, NULL, NULL, NULL) + (phalanx_length(NULL, NULL) != -1) + !isnan(phalanx_model(NULL, 0, NULL)) + (int)phalanx_steps(NULL) +
                    (int)phalanx_step(NULL) + (phalanx_time(NULL) != 0.0) + (phalanx_dt(NULL) != 0.0) + *phalanx_name(NULL);
        phalanx_fail(NULL, NULL);
        phalanx_clear(NULL);
        printf("%d %s %d\n", wrong, phalanx_error(NULL), phalanx_close(NULL));
        return 0;
    }
    me = phalanx_open(is("role") ? "pilot" : is("other role") ? "observer" : is("no role") ? NULL : "controller");
    if (is("second open")) {
        phalanx_participant *second = phalanx_open("controller");
        phalanx_fail(me, phalanx_error(second));
        phalanx_close(second);
    }
    if (is("channel")) phalanx_input(me, "states", 0, "position", 6);
    if (is("agent")) phalanx_input(me, "state", 17, "position", 6);
    if (is("signal")) phalanx_input(me, "state", 0, "positon", 6);
    if (is("length")) phalanx_input(me, "state", 0, "position", 3);
    if (is("no length")) phalanx_input(me, "state", 0, "position", -3);
    if (is("not read")) phalanx_input(me, "state", 5, "position", 6);
    if (is("output")) phalanx_output(me, 0, "inputs", 4);
    if (is("foreign output")) phalanx_output(me, 4, "input", 4);
    if (is("number")) phalanx_number(me, "controller.c_q");
    if (is("no number")) phalanx_number(me, "controller.intro");
    if (is("no text")) phalanx_text(me, "controller.c_p");
    if (is("no list")) phalanx_length(me, "controller.c_p");
    if (is("model")) phalanx_model(me, 0, "mass");
    if (is("early read")) phalanx_read(me, 0);
    if (is("early done")) phalanx_done(me);
    if (is("text bytes")) phalanx_text(me, "\xff");
    state = phalanx_input(me, "state", 0, "position", 6);
    input = phalanx_output(me, 0, "input", 4);
    for (k = 0; k < 5; ++k) others[k] = phalanx_output(me, 0, names[k], 3);
    while (phalanx_next(me)) {
        double *u = phalanx_write(me, input);
        int now = phalanx_step(me) == 7;
        if (now && is("forget")) ++u; /* the first number is not written */
        for (k = 0; k < 4 - (now && is("forget")); ++k) u[k] = 0.0;
        for (k = 0; k < 5; ++k) memset(phalanx_write(me, others[k]), 0, 3 * sizeof(double));
        if (now && is("infinite")) u[2] = HUGE_VAL;
        if (now && is("handle")) phalanx_read(me, 99);
        if (now && is("read output")) phalanx_read(me, input);
        if (now && is("write input")) phalanx_write(me, state);
        if (now && is("late")) phalanx_input(me, "state", 0, "velocity", 6);
        if (now && is("fail")) phalanx_fail(me, "the battery is empty");
        if (now && is("leave")) return phalanx_close(me);
        if (now && is("crash")) *(volatile int *)0 = 1;
        if (!(now && is("not done"))) phalanx_done(me);
        if (now && is("twice done")) phalanx_done(me);
        if (now && is("late read")) phalanx_read(me, state);
    }
    return phalanx_close(me);
}
