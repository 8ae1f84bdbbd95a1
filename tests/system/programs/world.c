/* A plant for the agents that it serves: double integrators, and what an accelerometer would show. */
#include <stdio.h>

#include <phalanx.h>

#define MOST 8

int main(void) {
    phalanx_participant *me = phalanx_open("plant");
    int agents[MOST], inputs[MOST], positions[MOST], velocities[MOST], imus[MOST];
    double x[MOST][3], v[MOST][3];
    const int count = phalanx_served(me, agents, MOST);
    const double dt = phalanx_dt(me), scale = phalanx_number(me, phalanx_parameter(me, 0, "scale"));
    for (int i = 0; i < count; ++i) {
        inputs[i] = phalanx_signal(me, "controller", agents[i], "input", 0, 1);
        positions[i] = phalanx_output(me, agents[i], "position", 3);
        velocities[i] = phalanx_output(me, agents[i], "velocity", 3);
        imus[i] = phalanx_output(me, agents[i], "imu", phalanx_size(me, "plant", agents[i], "imu"));
        for (int j = 0; j < 3; ++j) {
            x[i][j] = agents[i];
            v[i][j] = 0;
        }
    }
    while (phalanx_next(me)) {
        for (int i = 0; i < count; ++i) {
            const double *u = phalanx_read(me, inputs[i]);
            double *position = phalanx_write(me, positions[i]), *velocity = phalanx_write(me, velocities[i]);
            double *imu = phalanx_write(me, imus[i]);
            if (!u || !position || !velocity || !imu) break;
            for (int j = 0; j < 3; ++j) {
                if (phalanx_step(me) > 0) {
                    x[i][j] += dt * v[i][j] + dt * dt / 2 * u[j];
                    v[i][j] += dt * u[j];
                }
                position[j] = x[i][j];
                velocity[j] = v[i][j];
                imu[j] = scale * u[j];
            }
        }
        if (!phalanx_done(me)) break;
    }
    if (*phalanx_error(me)) fprintf(stderr, "%s\n", phalanx_error(me));
    return phalanx_close(me);
}
