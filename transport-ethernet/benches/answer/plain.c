/* The least that an answer over a packet socket takes: `plain echo IFACE` answers each PReq with a PRes, and looks at nothing else of
 * it. `plain poll IFACE MAC COUNT` brings a node to OPERATIONAL, polls it, and prints the median time from PReq to PRes in nanoseconds. */
#include <arpa/inet.h>
#include <linux/if_packet.h>
#include <net/if.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

enum { LEN = 60, TYPE = 14, STATE = 17, SOC = 1, PREQ = 3, PRES = 4, SOA = 5, ASND = 6, OPERATIONAL = 0xFD };

static int open_cable(const char *name)
{
	struct sockaddr_ll address = {
		.sll_family = AF_PACKET, .sll_protocol = htons(0x88AB), .sll_ifindex = (int)if_nametoindex(name)
	};
	int cable = socket(AF_PACKET, SOCK_RAW, 0);
	if (cable < 0 || bind(cable, (struct sockaddr *)&address, sizeof address)) {
		perror(name);
		exit(1);
	}
	return cable;
}

/* A frame of a managing node, or the PRes of node 1. */
static void make(unsigned char *frame, unsigned char group, const char *rest, size_t len)
{
	static const unsigned char head[] = { 0x01, 0x11, 0x1E, 0, 0, 0, 0x02, 0, 0, 0, 0, 0xF0, 0x88, 0xAB };
	memset(frame, 0, LEN);
	memcpy(frame, head, sizeof head);
	frame[5] = group;
	memcpy(frame + TYPE, rest, len);
}

static void put(int cable, const unsigned char *frame)
{
	if (send(cable, frame, LEN, 0) != LEN)
		exit(1);
}

static long now(void)
{
	struct timespec time;
	clock_gettime(CLOCK_MONOTONIC, &time);
	return time.tv_sec * 1000000000L + time.tv_nsec;
}

static int by_size(const void *one, const void *other)
{
	long a = *(const long *)one, b = *(const long *)other;
	return (a > b) - (a < b);
}

int main(int argc, char **argv)
{
	unsigned char soc[LEN], preq[LEN], pres[LEN], soa[LEN], enable[LEN], start[LEN], received[1514];
	if (argc < 3)
		return 2;
	int cable = open_cable(argv[2]);
	make(pres, 2, "\x04\xFF\x01\xFD\x01\0\0\0\x01\0\0", 11);
	if (!strcmp(argv[1], "echo")) {
		puts("ready");
		fflush(stdout);
		for (;;) {
			if (recv(cable, received, sizeof received, 0) < 0)
				return 1;
			if (received[TYPE] == PREQ)
				put(cable, pres);
		}
	}
	if (argc < 5)
		return 2;
	make(soc, 1, "\x01\xFF\xF0", 3);
	make(preq, 0, "\x03\x01\xF0\0\x01\0\0\0\x01\0\x2A", 11);
	make(soa, 3, "\x05\xFF\xF0\xFD\0\0\0\0\x20", 9);
	make(enable, 4, "\x06\x01\xF0\x04\x24", 5);
	make(start, 4, "\x06\x01\xF0\x04\x21", 5);
	if (sscanf(argv[3], "%hhx-%hhx-%hhx-%hhx-%hhx-%hhx", &preq[0], &preq[1], &preq[2], &preq[3], &preq[4], &preq[5]) != 6)
		return 2;
	int count = atoi(argv[4]);
	long *times = calloc((size_t)count, sizeof *times);
	put(cable, soa);
	put(cable, soc);
	put(cable, enable);
	put(cable, start);
	for (int i = -count / 10; i < count; i++) {
		put(cable, soc);
		long begin = now();
		put(cable, preq);
		do {
			if (recv(cable, received, sizeof received, 0) < 0)
				return 1;
		} while (received[TYPE] != PRES);
		long end = now();
		put(cable, soa);
		if (i < 0)
			continue;
		if (received[STATE] != OPERATIONAL)
			return 3;
		times[i] = end - begin;
	}
	qsort(times, (size_t)count, sizeof *times, by_size);
	printf("%ld\n", times[count / 2]);
	return 0;
}
