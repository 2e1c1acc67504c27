mod socketcand;
