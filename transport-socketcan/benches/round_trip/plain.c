/* The least that a round trip over SocketCAN takes: `plain echo IFACE`, and `plain ping IFACE COUNT` beside it. */
#include <linux/can.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

static int open_bus(const char *name, canid_t wanted)
{
	struct sockaddr_can address = { .can_family = AF_CAN, .can_ifindex = (int)if_nametoindex(name) };
	struct can_filter filter = { .can_id = wanted, .can_mask = CAN_SFF_MASK | CAN_EFF_FLAG };
	int bus = socket(PF_CAN, SOCK_RAW, CAN_RAW);
	if (bus < 0 || setsockopt(bus, SOL_CAN_RAW, CAN_RAW_FILTER, &filter, sizeof filter) ||
	    bind(bus, (struct sockaddr *)&address, sizeof address)) {
		perror(name);
		exit(1);
	}
	return bus;
}

int main(int argc, char **argv)
{
	struct can_frame frame = { .can_id = 0x100, .len = 8 };
	if (argc >= 3 && !strcmp(argv[1], "echo")) {
		int bus = open_bus(argv[2], 0x100);
		puts("ready");
		fflush(stdout);
		while (read(bus, &frame, sizeof frame) == sizeof frame) {
			frame.can_id = 0x101;
			if (write(bus, &frame, sizeof frame) != sizeof frame)
				return 1;
		}
		return 1;
	}
	if (argc < 4)
		return 2;
	int bus = open_bus(argv[2], 0x101);
	long count = atol(argv[3]);
	struct timespec begin, end;
	clock_gettime(CLOCK_MONOTONIC, &begin);
	for (long i = 0; i < count; i++) {
		frame.can_id = 0x100;
		if (write(bus, &frame, sizeof frame) != sizeof frame || read(bus, &frame, sizeof frame) != sizeof frame)
			return 1;
	}
	clock_gettime(CLOCK_MONOTONIC, &end);
	printf("%.9f\n", (double)(end.tv_sec - begin.tv_sec) + (double)(end.tv_nsec - begin.tv_nsec) / 1e9);
	return 0;
}
