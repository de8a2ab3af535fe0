/PROG  PRINT_001
/ATTR
OWNER		= MNEDITOR;
COMMENT		= "curvlay";
PROG_SIZE	= 0;
CREATE		= DATE 26-01-01  TIME 00:00:00;
MODIFIED	= DATE 26-01-01  TIME 00:00:00;
FILE_NAME	= ;
VERSION		= 0;
LINE_COUNT	= 11;
MEMORY_SIZE	= 0;
PROTECT		= READ_WRITE;
TCD:  STACK_SIZE	= 0,
      TASK_PRIORITY	= 50,
      TIME_SLICE	= 0,
      BUSY_LAMP_OFF	= 0,
      ABORT_REQUEST	= 0,
      PAUSE_REQUEST	= 0;
DEFAULT_GROUP	= 1,*,*,*,*;
CONTROL_CODE	= 00000000 00000000;
/MN
   1:  UFRAME_NUM=1 ;
   2:  UTOOL_NUM=1 ;
   3:J P[1] 32% FINE ;
   4:L P[2] 20mm/sec FINE ;
   5:  DO[1]=ON ;
   6:  AO[1]=500 ;
   7:L P[3] 20mm/sec CNT50 ;
   8:  AO[1]=600 ;
   9:L P[4] 20mm/sec FINE ;
  10:  AO[1]=0 ;
  11:  DO[1]=OFF ;
/POS
P[1]{
   GP1:
	UF : 1, UT : 1,	
	J1= 0 deg,	J2= 0 deg,	J3= 0 deg,
	J4= 0 deg,	J5= -90 deg,	J6= 60 deg
};
P[2]{
   GP1:
	UF : 1, UT : 1,	CONFIG : 'N U T, 0, 0, 0',
	X = 0 mm,	Y = 0 mm,	Z = 300 mm,
	W = 0 deg,	P = 0 deg,	R = 0 deg
};
P[3]{
   GP1:
	UF : 1, UT : 1,	CONFIG : 'N U T, 0, 0, 0',
	X = 10 mm,	Y = 0 mm,	Z = 300 mm,
	W = 0 deg,	P = 0 deg,	R = 0 deg
};
P[4]{
   GP1:
	UF : 1, UT : 1,	CONFIG : 'N U T, 0, 0, 0',
	X = 20 mm,	Y = 0 mm,	Z = 300 mm,
	W = 0 deg,	P = 0 deg,	R = 0 deg
};
/END
