/* The law of the scenario of tests/system/links.rs: consensus on what is received of the neighbours, and how old it is. */
#include <stdio.h>

#include <phalanx.h>

#define MOST 8

int main(void) {
    phalanx_participant *me = phalanx_open("controller");
    int neighbours[MOST], xs[MOST], ys[MOST], ages[MOST];
    const int count = phalanx_neighbours(me, 0, neighbours, MOST);
    const int own_x = phalanx_input(me, "state", 0, "x", 1), own_y = phalanx_input(me, "state", 0, "y", 1);
    for (int k = 0; k < count; ++k) {
        xs[k] = phalanx_input(me, "state", neighbours[k], "x", 1);
        ys[k] = phalanx_signal(me, "plant", neighbours[k], "y", 0, 0);
        ages[k] = phalanx_input(me, "state", neighbours[k], "link_age", 1);
    }
    const int input = phalanx_output(me, 0, "input", 2), age = phalanx_output(me, 0, "age", 1);
    while (phalanx_next(me)) {
        double *u = phalanx_write(me, input), *old = phalanx_write(me, age);
        if (!u || !old) break;
        u[0] = u[1] = *old = 0;
        for (int k = 0; k < count; ++k) {
            u[0] += *phalanx_read(me, xs[k]) - *phalanx_read(me, own_x);
            u[1] += *phalanx_read(me, ys[k]) - *phalanx_read(me, own_y);
            *old += *phalanx_read(me, ages[k]);
        }
        if (!phalanx_done(me)) break;
    }
    if (*phalanx_error(me)) fprintf(stderr, "%s\n", phalanx_error(me));
    return phalanx_close(me);
}
