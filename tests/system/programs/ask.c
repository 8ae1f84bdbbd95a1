/* A controller of three planar robots that prints what it can ask for, deals with an error, and tracks its reference. */
#include <stdio.h>

#include <phalanx.h>

int main(void)
{
    static const char *const names[] = {"agents.2.position.3", "topology.A.1.3", "topology.A.1.2", "topology.b.2",
                                        "controller.k_v", "controller.every", "timing.dt", "parameters.half"};
    phalanx_participant *me = phalanx_open("controller");
    const double x[3] = {1.0, 2.0, 3.0}, v[3] = {0.0, 4.0, 0.0};
    double added[3] = {7.0, 7.0, 7.0};
    int neighbours[2] = {0, 0};
    for (int k = 0; k < 8; ++k) printf("%s %.17g\n", names[k], phalanx_number(me, names[k]));
    printf("weight %g %g b %g\n", phalanx_weight(me, 1, 3), phalanx_weight(me, 1, 2), phalanx_b(me, 0));
    const int count = phalanx_neighbours(me, 0, neighbours, 2);
    printf("neighbours %d first %d\n", count, neighbours[0]);
    const int written = phalanx_disturbance(me, 2, 1.5, x, v, added);
    printf("disturbance %d: %g %g %g\n", written, added[0], added[1], added[2]);
    phalanx_mismatched(me, 2, 1.5, x, NULL, added);
    printf("mismatched %g %g %g\n", added[0], added[1], added[2]);
    phalanx_number(me, "controller.k_q");
    phalanx_weight(me, 1, 9);
    printf("error %s\n", phalanx_error(me));
    phalanx_clear(me);
    phalanx_weight(me, 1, 9);
    printf("later %s\n", phalanx_error(me));
    phalanx_clear(me);
    fflush(stdout);
    const int state = phalanx_input(me, "state", 0, "position", 3), speed = phalanx_input(me, "state", 0, "velocity", 3);
    const int target = phalanx_input(me, "reference", 0, "position", 3), input = phalanx_output(me, 0, "input", 3);
    while (phalanx_next(me)) {
        const double *p = phalanx_read(me, state), *w = phalanx_read(me, speed), *r = phalanx_read(me, target);
        double *u = phalanx_write(me, input);
        for (int j = 0; j < 3; ++j) u[j] = 4.0 * (r[j] - p[j]) - 4.0 * w[j];
        phalanx_done(me);
    }
    return phalanx_close(me);
}
