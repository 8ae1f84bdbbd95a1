/* A controller for the scenario `uav` in plain C: it lets a quadcopter hover where it started.
 *
 *     cargo build --release -p capi
 *     cc -std=c11 -O2 -I capi/include -o hover examples/controller-c/controller.c -L target/release -lphalanx \
 *         -Wl,-rpath,"$PWD/target/release"
 *     phalanx run uav --variant apart --duration 30 --swap controller.3=./hover
 */
#include <stdio.h>

#include <phalanx.h>

static double damped(double gain, double error, double rate) { return -gain * gain * error - 2.0 * gain * rate; }

int main(void)
{
    static const char *const unused[] = {"attitude_reference", "xi1", "xi2", "sliding_position", "sliding_attitude"};
    phalanx_participant *me = phalanx_open("controller");
    const double mass = phalanx_model(me, 0, "m"), arm = phalanx_model(me, 0, "R");
    const double effect[3] = {arm / phalanx_model(me, 0, "Jx"), arm / phalanx_model(me, 0, "Jy"),
                              phalanx_model(me, 0, "upsilon") / phalanx_model(me, 0, "Jz")};
    const int state = phalanx_input(me, "state", 0, "position", 6), speed = phalanx_input(me, "state", 0, "velocity", 6);
    const int input = phalanx_output(me, 0, "input", 4);
    double start[3] = {0.0, 0.0, 0.0};
    int others[5];
    for (int k = 0; k < 5; ++k) others[k] = phalanx_output(me, 0, unused[k], 3);

    while (phalanx_next(me)) {
        const double *x = phalanx_read(me, state), *v = phalanx_read(me, speed);
        double *u = phalanx_write(me, input);
        if (phalanx_step(me) == 0)
            for (int j = 0; j < 3; ++j) start[j] = x[j];

        /* A tilt accelerates sideways: pitch along x, roll against y. */
        const double tilt[3] = {-damped(1.0, x[1] - start[1], v[1]) / 9.81, damped(1.0, x[0] - start[0], v[0]) / 9.81, 0.0};
        u[0] = mass * (9.81 + damped(2.0, x[2] - start[2], v[2]));
        for (int j = 0; j < 3; ++j) u[1 + j] = damped(4.0, x[3 + j] - tilt[j], v[3 + j]) / effect[j];
        for (int k = 0; k < 5; ++k) {
            double *other = phalanx_write(me, others[k]);
            for (int j = 0; j < 3; ++j) other[j] = k == 0 ? tilt[j] : 0.0;
        }
        phalanx_done(me);
    }
    if (*phalanx_error(me)) fprintf(stderr, "%s\n", phalanx_error(me));
    return phalanx_close(me);
}
